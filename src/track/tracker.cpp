#include "extperfc/track/tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "extperfc/base/demand.hpp"
#include "extperfc/track/assignment.hpp"

namespace extperfc::track {

namespace {

constexpr double kVotesKept = 0.9;  // of the votes for classes, with every observation

struct Check {
  bool ok;
  const char* what;
  double value;
};

bool positive(double value) {
  return std::isfinite(value) && value > 0.0;
}

bool usable(const Observation& observation) {
  return observation.position_m.allFinite() && observation.covariance_m2.allFinite();
}

}  // namespace

Result<void> validate(const TrackerParams& p) {
  const std::array<Check, 10> checks{{
      {positive(p.acceleration_m_s2), "acceleration_m_s2 must be positive and finite", p.acceleration_m_s2},
      {positive(p.speed_m_s), "speed_m_s must be positive and finite", p.speed_m_s},
      {positive(p.min_sigma_m), "min_sigma_m must be positive and finite", p.min_sigma_m},
      {positive(p.gate), "gate must be positive and finite", p.gate},
      {std::isfinite(p.class_cost) && p.class_cost >= 0.0, "class_cost must be finite and not negative",
       p.class_cost},
      {p.confirm_hits >= 1, "confirm_hits must be at least 1", static_cast<double>(p.confirm_hits)},
      {positive(p.max_missed_s), "max_missed_s must be positive and finite", p.max_missed_s},
      {positive(p.max_missed_new_s), "max_missed_new_s must be positive and finite", p.max_missed_new_s},
      {p.max_tracks >= 1, "max_tracks must be at least 1", static_cast<double>(p.max_tracks)},
      {std::isfinite(p.manoeuvre_m_s) && p.manoeuvre_m_s >= 0.0,
       "manoeuvre_m_s must be finite and not negative", p.manoeuvre_m_s},
  }};
  for (const auto& check : checks)
    if (!check.ok)
      return fail(ErrorCode::kInvalidArgument,
                  std::string("tracker: ") + check.what + ", not " + std::to_string(check.value));
  return {};
}

int Track::class_index() const {
  const auto best = std::max_element(votes.begin(), votes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == votes.end() ? -1 : best->first;
}

Tracker::Tracker(const TrackerParams& params) : params_(params) {
  const auto valid = validate(params);
  demand(valid.has_value(), valid ? "" : valid.error().message);
}

Tracker::Status Tracker::update(double stamp_s, const std::vector<Observation>& observations) {
  auto status = Status::kUpdated;
  if (stamp_s_ && stamp_s < *stamp_s_) {
    if (stamp_s >= *stamp_s_ - params_.max_missed_s) return Status::kTooOld;
    tracks_.clear();
    stamp_s_.reset();
    status = Status::kRestarted;
  }
  forget(stamp_s);  // first: after a long gap everything would lie inside the gate of an old object
  const double dt_s = stamp_s_ ? stamp_s - *stamp_s_ : 0.0;
  predict(dt_s);
  stamp_s_ = stamp_s;
  std::vector<bool> taken(observations.size(), false);
  give(match(tracks_, observations, taken), stamp_s, observations, taken);
  if (params_.manoeuvre_m_s > 0) match_manoeuvres(dt_s, stamp_s, observations, taken);
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (!taken[i] && usable(observations[i])) begin(stamp_s, i, observations[i]);
  return status;
}

void Tracker::predict(double dt_s) {
  for (auto& track : tracks_) {
    track.point.predict(dt_s, params_.acceleration_m_s2);
    track.observation.reset();
  }
}

void Tracker::give(const Matches& matches, double stamp_s, const std::vector<Observation>& observations,
                   std::vector<bool>& taken) {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!matches[i]) continue;
    taken[*matches[i]] = true;
    tracks_[i].observation = matches[i];
    correct(tracks_[i], stamp_s, observations[*matches[i]]);
  }
}

/// Second: who goes on as before is told apart by that, also from who turns round beside them.
void Tracker::match_manoeuvres(double dt_s, double stamp_s, const std::vector<Observation>& observations,
                               std::vector<bool>& taken) {
  std::vector<Track> missed;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].observation || !tracks_[i].confirmed) continue;
    indices.push_back(i);
    missed.push_back(tracks_[i]);
    missed.back().point.disturb(dt_s, params_.manoeuvre_m_s);
  }
  if (missed.empty()) return;
  const Matches found = match(missed, observations, taken);
  Matches matches(tracks_.size());
  for (std::size_t i = 0; i < missed.size(); ++i) {
    if (!found[i]) continue;
    tracks_[indices[i]].point = missed[i].point;
    matches[indices[i]] = found[i];
  }
  give(matches, stamp_s, observations, taken);
}

Tracker::Matches Tracker::match(const std::vector<Track>& tracks,
                                const std::vector<Observation>& observations,
                                const std::vector<bool>& taken) const {
  const double outside = params_.gate + params_.class_cost + 1.0;  // more than any pair inside the gate
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(tracks.size()),
                                                   static_cast<Eigen::Index>(observations.size()), outside);
  for (std::size_t t = 0; t < tracks.size(); ++t)
    for (std::size_t o = 0; o < observations.size(); ++o) {
      const auto& seen = observations[o];
      if (taken[o] || !usable(seen)) continue;
      const double distance2 = tracks[t].point.distance2(seen.position_m, floored(seen.covariance_m2));
      if (!(distance2 <= params_.gate)) continue;
      const bool same = tracks[t].class_index() == seen.class_index;
      cost(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(o)) =
          distance2 + (same ? 0.0 : params_.class_cost);
    }
  const auto column_of = assign(cost);
  Matches matched(tracks.size());
  for (std::size_t t = 0; t < tracks.size(); ++t)
    if (column_of[t] >= 0 && cost(static_cast<Eigen::Index>(t), column_of[t]) < outside)
      matched[t] = static_cast<std::size_t>(column_of[t]);
  return matched;
}

void Tracker::correct(Track& track, double stamp_s, const Observation& observation) const {
  track.point.correct(observation.position_m, floored(observation.covariance_m2));
  for (auto& [class_index, votes] : track.votes) votes *= kVotesKept;
  track.votes[observation.class_index] += observation.score;
  track.score = observation.score;
  track.last_seen_s = stamp_s;
  ++track.hits;
  track.confirmed = track.confirmed || track.hits >= params_.confirm_hits;
}

void Tracker::begin(double stamp_s, std::size_t index, const Observation& observation) {
  if (tracks_.size() >= static_cast<std::size_t>(params_.max_tracks)) return;
  Track track{next_id_++,
              MovingPoint(observation.position_m, floored(observation.covariance_m2), params_.speed_m_s),
              {{observation.class_index, observation.score}},
              observation.score,
              1,
              params_.confirm_hits == 1,
              stamp_s,
              stamp_s,
              index};
  tracks_.push_back(std::move(track));
}

void Tracker::forget(double stamp_s) {
  const auto too_long = [&](const Track& track) {
    return stamp_s - track.last_seen_s > (track.confirmed ? params_.max_missed_s : params_.max_missed_new_s);
  };
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), too_long), tracks_.end());
}

/// Neither smaller than the floor nor singular.
Eigen::Matrix3d Tracker::floored(const Eigen::Matrix3d& covariance_m2) const {
  return covariance_m2 + params_.min_sigma_m * params_.min_sigma_m * Eigen::Matrix3d::Identity();
}

}  // namespace extperfc::track
