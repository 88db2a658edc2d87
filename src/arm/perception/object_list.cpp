#include "extperfc/arm/object_list.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "extperfc/base/math.hpp"

namespace extperfc::arm {
namespace {

constexpr double kSame = 1e-6;  ///< poses that differ by less are the same [m, rad]

double angle_between(const Pose& a, const Pose& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.linear().transpose() * b.linear())).angle();
}

bool differ(const Pose& a, const Pose& b, double min_m, double min_rad) {
  return (a.translation() - b.translation()).norm() > min_m || angle_between(a, b) > min_rad;
}

/// The same box with the yaw nearest to `yaw_rad`.
UprightBox rotated_to(UprightBox box, double yaw_rad) {
  const double quarters = std::round((yaw_rad - box.yaw_rad) / (kPi / 2));
  box.yaw_rad += quarters * kPi / 2;
  if (std::abs(std::fmod(quarters, 2.0)) > 0.5) std::swap(box.size_m.x(), box.size_m.y());
  return box;
}

bool inside(const Eigen::Vector3d& middle_m, const Eigen::Vector3d& other_middle_m,
            const Eigen::Vector3d& other_size_m) {
  return (middle_m - other_middle_m).norm() < 0.5 * other_size_m.minCoeff();
}

}  // namespace

Result<void> ObjectListParams::validate() const {
  const auto wrong = [](const char* what) { return fail(ErrorCode::kInvalidArgument, what); };
  if (confirm < 1 || confirm > 100) return wrong("confirm must be from 1 to 100");
  if (!(max_age_s >= 0.0 && max_age_s <= 1e6)) return wrong("max_age_s must be from 0 to 1e6");
  if (!(match_m >= 0.001 && match_m <= 10.0)) return wrong("match_m must be from 0.001 to 10");
  if (max_objects < 1 || max_objects > 500) return wrong("max_objects must be from 1 to 500");
  if (!(min_change_m >= 0.0 && min_change_m <= 1.0)) return wrong("min_change_m must be from 0 to 1");
  if (!(min_change_rad >= 0.0 && min_change_rad <= 3.15))
    return wrong("min_change_rad must be from 0 to 3.15");
  if (average < 1 || average > 1000) return wrong("average must be from 1 to 1000");
  if (!(new_score >= 0.0 && new_score <= 1.0)) return wrong("new_score must be from 0 to 1");
  return {};
}

Result<ObjectList> ObjectList::make(const ObjectListParams& params) {
  if (const auto fits = params.validate(); !fits) return tl::unexpected(fits.error());
  return ObjectList(params);
}

ObjectListUpdate ObjectList::update(const std::vector<ObjectDetection>& detections,
                                    const std::vector<KnownObject>& scene, double time_s) {
  ObjectListUpdate done;
  for (auto& track : tracks_) track.seen_s = std::min(track.seen_s, time_s);
  done.changed = follow(scene, time_s);
  const auto matches = match(detections);
  for (auto& track : tracks_) ++track.missed;
  const auto is_claimed = [&](std::size_t i) { return claimed(detections[i], scene); };
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (matches[i] < 0) continue;
    Track& track = tracks_[static_cast<std::size_t>(matches[i])];
    ++done.matched;
    if (!is_claimed(i) && !detections[i].ambiguous) {
      see(track, detections[i], time_s);
    } else if (!track.name.empty()) {
      // It may be the other object that is seen: it is there, but who knows where.
      track.seen_s = time_s;
      track.missed = 0;
    }
  }
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (matches[i] >= 0) continue;
    if (is_claimed(i))
      ++done.claimed;
    else if (detections[i].ambiguous)
      ++done.ambiguous;
    else if (detections[i].score < params_.new_score)
      ++done.doubtful;
    else
      begin(detections[i], time_s, done);
  }
  done.changed = leave(time_s) || done.changed;
  for (auto& track : tracks_) done.changed = show(track) || done.changed;
  done.changed = join(scene) || done.changed;
  done.waiting = count(false);
  return done;
}

/// What others did to the scene. True when an object went.
bool ObjectList::follow(const std::vector<KnownObject>& scene, double time_s) {
  const auto object_of = [&](const Track& track) {
    return std::find_if(scene.begin(), scene.end(),
                        [&](const KnownObject& one) { return one.name == track.name; });
  };
  const auto gone = [&](const Track& track) {
    const auto object = object_of(track);
    return !track.name.empty() && (object == scene.end() || !object->listed);
  };
  const auto end = std::remove_if(tracks_.begin(), tracks_.end(), gone);
  const bool changed = end != tracks_.end();
  tracks_.erase(end, tracks_.end());
  for (auto& track : tracks_) {
    if (track.name.empty()) continue;
    const KnownObject& object = *object_of(track);
    track.still = object.still;
    if (track.still || differ(object.world_T_object, track.shown, kSame, kSame))
      put(track, object.world_T_object, time_s);
  }
  return changed;
}

/// For each detection its object, -1: none.
std::vector<int> ObjectList::match(const std::vector<ObjectDetection>& detections) const {
  std::vector<std::tuple<bool, double, int, int>> pairs;
  for (std::size_t t = 0; t < tracks_.size(); ++t)
    for (std::size_t s = 0; s < detections.size(); ++s) {
      if (tracks_[t].still || tracks_[t].label != detections[s].label) continue;
      const double away = (tracks_[t].last_m - detections[s].box.position_m).norm();
      if (away <= params_.match_m)
        pairs.emplace_back(detections[s].ambiguous, away, static_cast<int>(t), static_cast<int>(s));
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> matches(detections.size(), -1);
  std::vector<bool> taken(tracks_.size(), false);
  for (const auto& [ambiguous, away, t, s] : pairs) {
    if (taken[static_cast<std::size_t>(t)] || matches[static_cast<std::size_t>(s)] >= 0) continue;
    taken[static_cast<std::size_t>(t)] = true;
    matches[static_cast<std::size_t>(s)] = t;
  }
  return matches;
}

bool ObjectList::claimed(const ObjectDetection& detection, const std::vector<KnownObject>& scene) const {
  const auto near = [&](const Eigen::Vector3d& place) {
    return (place - detection.box.position_m).norm() <= params_.match_m;
  };
  return std::any_of(scene.begin(), scene.end(), [&](const KnownObject& object) {
    const bool held = !object.places.empty();  // rotated by the gripper, it may be detected as another class
    return object.still && (held || object.label == detection.label) &&
           (near(object.world_T_object.translation()) ||
            std::any_of(object.places.begin(), object.places.end(), near));
  });
}

/// Others say where it is.
void ObjectList::put(Track& track, const Pose& pose, double time_s) const {
  track.shown = pose;
  track.last_m = pose.translation();
  track.mean.position_m = pose.translation();
  track.mean.yaw_rad = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
  track.mean.size_m = track.shown_size_m;
  track.count = 0;
  track.far = 0;
  track.missed = 0;
  track.seen_s = time_s;
}

void ObjectList::see(Track& track, const ObjectDetection& detection, double time_s) const {
  track.seen_s = time_s;
  track.missed = 0;
  if (detection.score >= params_.new_score)
    track.detections = std::min(track.detections + 1, params_.confirm);
  track.last_m = detection.box.position_m;
  const UprightBox box = rotated_to(detection.box, track.mean.yaw_rad);
  if (track.count > 0 && (box.position_m - track.mean.position_m).norm() > 0.5 * params_.match_m) {
    if (++track.far < params_.confirm) return;
    track.count = 0;
  }
  track.far = 0;
  track.count = std::min(track.count + 1, params_.average);
  const double weight = 1.0 / track.count;
  track.mean.position_m += weight * (box.position_m - track.mean.position_m);
  track.mean.size_m += weight * (box.size_m - track.mean.size_m);
  track.mean.yaw_rad = wrap_angle(track.mean.yaw_rad + weight * (box.yaw_rad - track.mean.yaw_rad));
}

/// A detection of nothing known.
void ObjectList::begin(const ObjectDetection& detection, double time_s, ObjectListUpdate& done) {
  const auto doubles = [&](const Track& track) {
    return (track.still || track.missed < params_.confirm) &&
           inside(detection.box.position_m, track.last_m, track.mean.size_m);
  };
  if (std::any_of(tracks_.begin(), tracks_.end(), doubles)) {
    ++done.duplicate;
    return;
  }
  if (count(false) >= params_.max_objects) {
    ++done.no_room;
    return;
  }
  Track track;
  track.label = detection.label;
  track.mean = detection.box;
  see(track, detection, time_s);
  tracks_.push_back(std::move(track));
}

/// True when an object went.
bool ObjectList::leave(double time_s) {
  bool changed = false;
  const auto gone = [&](const Track& track) {
    if (track.name.empty()) return track.missed >= params_.confirm;
    const bool old = !track.still && params_.max_age_s > 0.0 && time_s - track.seen_s > params_.max_age_s;
    changed = changed || old;
    return old;
  };
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), gone), tracks_.end());
  return changed;
}

/// True when an object came.
bool ObjectList::join(const std::vector<KnownObject>& scene) {
  std::set<std::string> gone;
  bool changed = false;
  for (auto& track : tracks_) {
    if (!track.name.empty() || track.detections < params_.confirm) continue;
    if (count(true) >= params_.max_objects) break;
    for (const auto& other : tracks_)
      if (!other.name.empty() && !other.still && other.missed >= params_.confirm &&
          inside(track.mean.position_m, other.mean.position_m, other.mean.size_m))
        gone.insert(other.name);
    track.name = free_name(track.label, scene);
    track.shown = pose_of(track.mean);
    track.shown_size_m = track.mean.size_m;
    changed = true;
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [&](const Track& track) { return gone.count(track.name) > 0; }),
                tracks_.end());
  return changed;
}

/// True when the object is shown elsewhere or otherwise than before.
bool ObjectList::show(Track& track) const {
  if (track.name.empty() || track.still || track.count == 0) return false;
  const Pose pose = pose_of(track.mean);
  const bool resized =
      ((track.mean.size_m - track.shown_size_m).cwiseAbs().array() > params_.min_change_m).any();
  if (!resized && !differ(pose, track.shown, params_.min_change_m, params_.min_change_rad)) return false;
  track.shown = pose;
  track.shown_size_m = track.mean.size_m;
  return true;
}

std::string ObjectList::free_name(const std::string& label, const std::vector<KnownObject>& scene) const {
  const auto taken = [&](const std::string& name) {
    const auto has_it = [&](const auto& one) { return one.name == name; };
    return std::any_of(tracks_.begin(), tracks_.end(), has_it) ||
           std::any_of(scene.begin(), scene.end(), has_it);
  };
  for (int n = 1;; ++n)
    if (auto name = label + "_" + std::to_string(n); !taken(name)) return name;
}

int ObjectList::count(bool listed) const {
  return static_cast<int>(std::count_if(tracks_.begin(), tracks_.end(),
                                        [&](const Track& track) { return track.name.empty() != listed; }));
}

std::vector<ListedObject> ObjectList::objects() const {
  std::vector<ListedObject> listed;
  for (const auto& track : tracks_)
    if (!track.name.empty()) listed.push_back({track.name, track.label, track.shown, track.shown_size_m});
  return listed;
}

}  // namespace extperfc::arm
