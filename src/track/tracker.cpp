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
  const std::array<Check, 9> checks{{
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
  predict(stamp_s);
  const auto matched = match(observations);
  std::vector<bool> taken(observations.size(), false);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    tracks_[i].observation = matched[i];
    if (!matched[i]) continue;
    taken[*matched[i]] = true;
    correct(tracks_[i], stamp_s, observations[*matched[i]]);
  }
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (!taken[i] && usable(observations[i])) begin(stamp_s, i, observations[i]);
  return status;
}

void Tracker::predict(double stamp_s) {
  const double dt_s = stamp_s_ ? stamp_s - *stamp_s_ : 0.0;
  for (auto& track : tracks_) track.point.predict(dt_s, params_.acceleration_m_s2);
  stamp_s_ = stamp_s;
}

std::vector<std::optional<std::size_t>> Tracker::match(const std::vector<Observation>& observations) const {
  const double outside = params_.gate + params_.class_cost + 1.0;  // more than any pair inside the gate
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(tracks_.size()),
                                                   static_cast<Eigen::Index>(observations.size()), outside);
  for (std::size_t t = 0; t < tracks_.size(); ++t)
    for (std::size_t o = 0; o < observations.size(); ++o) {
      const auto& seen = observations[o];
      if (!usable(seen)) continue;
      const double distance2 = tracks_[t].point.distance2(seen.position_m, floored(seen.covariance_m2));
      if (!(distance2 <= params_.gate)) continue;
      const bool same = tracks_[t].class_index() == seen.class_index;
      cost(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(o)) =
          distance2 + (same ? 0.0 : params_.class_cost);
    }
  const auto column_of = assign(cost);
  std::vector<std::optional<std::size_t>> matched(tracks_.size());
  for (std::size_t t = 0; t < tracks_.size(); ++t)
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
