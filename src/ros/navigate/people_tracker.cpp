#include "ros/navigate/people_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "ros/convert/tracks.hpp"

namespace extperfc::ros_navigate {

namespace {

constexpr double kWalksMS = 0.25;  // who never was faster is furniture: part of the cost maps
constexpr double kFastestMS = 2.5;
constexpr double kFarM = 1.0;
constexpr double kStepsM = 0.5;  // are far enough into a place that was empty when the walk began
constexpr double kPlaceM = 0.2;  // half a person's width: the size of a place that is looked through
constexpr double kPositionSigmaM = 0.06;
constexpr double kNewS = 2.5;    // after this time in sight who walks has walked kFarM
constexpr double kCloseM = 2.5;  // what is nearer counts as an obstacle at once
constexpr double kOldS = 1.0;
constexpr double kRadiusM = 0.25;  // of a person, at least
constexpr double kHeightM = 1.7;

navigate::MovingObjectParams detector_params(const ros_params::PeopleParams& params) {
  navigate::MovingObjectParams made;
  made.max_range_m = params.max_range_m;
  return made;
}

track::TrackerParams tracker_params() {
  track::TrackerParams params;
  params.acceleration_m_s2 = 1.0;
  params.speed_m_s = 0.8;
  params.confirm_hits = 4;
  params.max_missed_s = 0.6;
  params.manoeuvre_m_s = 1.2;  // who walks 1.4 m/s and turns round from one scan to the next
  return params;
}

double radius_of(const track::Track& track, const std::vector<navigate::MovingCandidate>& candidates) {
  return track.observation ? std::max(kRadiusM, candidates[*track.observation].radius_m) : kRadiusM;
}

/// Whether the rays to a place in odom, and to what is beside it, end behind it. NaN says nothing: no.
bool looks_through(const PlacedScan& placed, const Eigen::Vector2d& place_m) {
  const LaserScan& scan = placed.scan;
  const Pose2 at = between(compose(placed.odom_T_base, scan.base_T_sensor), {place_m.x(), place_m.y(), 0});
  const double away_m = std::hypot(at.x, at.y);
  const double half_rad = kPlaceM / std::max(away_m, kPlaceM);
  const double bearing = std::atan2(at.y, at.x);
  bool any = false;
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const double angle = scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
    if (std::abs(wrap_angle(angle - bearing)) > half_rad) continue;
    if (!(scan.ranges[ray] > away_m + kPlaceM)) return false;
    any = true;
  }
  return any;
}

}  // namespace

PeopleTracker::PeopleTracker(const ros_params::PeopleParams& params)
    : params_(params), detector_(detector_params(params)), tracker_(tracker_params()) {}

void PeopleTracker::set_map(const OccupancyGrid& map) {
  if (!params_.enabled) return;
  const std::lock_guard lock(mutex_);
  detector_.set_map(map, stamp_s_);
}

void PeopleTracker::forget() {
  const std::lock_guard lock(mutex_);
  tracker_ = track::Tracker(tracker_params());
  people_.clear();
  newcomers_.clear();
  walks_.clear();
}

void PeopleTracker::update(const PlacedScan& placed) {
  if (!params_.enabled || !placed.map_T_odom) return;
  const std::lock_guard lock(mutex_);
  auto pedestrians = at(placed.scan.stamp_s, Which::kFar);
  for (auto& pedestrian : pedestrians) {
    const Pose2 place =
        compose(*placed.map_T_odom, {pedestrian.position_m.x(), pedestrian.position_m.y(), 0});
    pedestrian.position_m = {place.x, place.y};
  }
  const auto candidates =
      detector_.detect(placed.scan, compose(*placed.map_T_odom, placed.odom_T_base), pedestrians);
  const Pose2 odom_T_map = inverse(*placed.map_T_odom);
  std::vector<track::Observation> observations;
  observations.reserve(candidates.size());
  for (const auto& candidate : candidates) {
    const Pose2 place = compose(odom_T_map, {candidate.centre_m.x(), candidate.centre_m.y(), 0});
    track::Observation one;
    one.score = 1;
    one.position_m = {place.x, place.y, 0};
    one.covariance_m2 = kPositionSigmaM * kPositionSigmaM * Eigen::Matrix3d::Identity();
    observations.push_back(one);
  }
  if (tracker_.update(placed.scan.stamp_s, observations) == track::Tracker::Status::kTooOld) return;
  stamp_s_ = placed.scan.stamp_s;
  note_newcomers(candidates, {placed.odom_T_base.x, placed.odom_T_base.y});
  note_people(placed, candidates);
}

/// What marks the cost map before it is known to walk leaves marks where it does not stay, and hides them
/// from the lidar when it walks towards the robot.
void PeopleTracker::note_newcomers(const std::vector<navigate::MovingCandidate>& candidates,
                                   const Eigen::Vector2d& robot_m) {
  newcomers_.clear();
  for (const auto& track : tracker_.tracks()) {
    const Eigen::Vector2d at_m = track.point.position_m().head<2>();
    if (stamp_s_ - track.first_seen_s >= kNewS || (at_m - robot_m).norm() < kCloseM) continue;
    newcomers_.push_back({at_m, {0, 0}, radius_of(track, candidates)});
  }
}

void PeopleTracker::note_people(const PlacedScan& placed,
                                const std::vector<navigate::MovingCandidate>& candidates) {
  people_.clear();
  const auto now = std::make_shared<const PlacedScan>(placed);
  std::map<std::uint64_t, Walk> seen;
  for (const auto& track : tracker_.tracks()) {
    const Eigen::Vector2d position_m = track.point.position_m().head<2>();
    const Eigen::Vector2d velocity_m_s = track.point.velocity_m_s().head<2>();
    const double speed = velocity_m_s.norm();
    Walk& walk = seen[track.id] = walks_.try_emplace(track.id, Walk{position_m, now}).first->second;
    // For a moment who turns round seems to be faster than anybody is.
    const bool walks = track.confirmed && speed >= kWalksMS && (walk.last_s || speed <= kFastestMS);
    if (walks) walk.last_s = stamp_s_;
    if (!walk.last_s) continue;
    walk.far = walk.far || came_far(walk, position_m, placed);
    if (!walks && !walk.far) continue;  // the edge of a table, of which another part came into sight
    Person person;
    person.state.position_m = position_m;
    if (walks) person.state.velocity_m_s = std::min(1.0, kFastestMS / speed) * velocity_m_s;
    person.far = walk.far;
    person.passes = passes(walk);
    person.state.radius_m = radius_of(track, candidates);
    people_.push_back(person);
  }
  walks_ = std::move(seen);
}

bool PeopleTracker::came_far(const Walk& walk, const Eigen::Vector2d& at_m, const PlacedScan& placed) {
  const double moved_m = (at_m - walk.begin_m).norm();
  const double alone_m = moved_m - distance_m(placed.odom_T_base, walk.began->odom_T_base);
  if (alone_m >= kFarM || (moved_m >= kFarM && looks_through(placed, walk.begin_m))) return true;
  return alone_m >= kStepsM && looks_through(*walk.began, at_m);
}

bool PeopleTracker::passes(const Walk& walk) const {
  return walk.far && walk.last_s && stamp_s_ - *walk.last_s < params_.stand_s;
}

std::vector<navigate::MovingObstacle> PeopleTracker::people(double now_s) const {
  const std::lock_guard lock(mutex_);
  return at(now_s, Which::kAll);
}

std::vector<navigate::MovingObstacle> PeopleTracker::passers(double now_s) const {
  const std::lock_guard lock(mutex_);
  return at(now_s, Which::kPassers);
}

std::vector<navigate::MovingObstacle> PeopleTracker::at(double now_s, Which which) const {
  const double age_s = now_s - stamp_s_;
  if (std::abs(age_s) > kOldS) return {};
  auto people = which == Which::kPassers ? newcomers_ : std::vector<navigate::MovingObstacle>{};
  people.reserve(people.size() + people_.size());
  for (const auto& person : people_) {
    if ((which == Which::kFar && !person.far) || (which == Which::kPassers && !person.passes)) continue;
    people.push_back(person.state);
    people.back().position_m += age_s * person.state.velocity_m_s;
  }
  return people;
}

TrackArray PeopleTracker::tracks(const std::string& odom_frame) const {
  const std::lock_guard lock(mutex_);
  TrackArray message;
  message.header.stamp = ros::Time(stamp_s_);
  message.header.frame_id = odom_frame;
  ros_convert::TrackedBody body;
  body.orientation.w = 1;
  body.size.x = body.size.y = 2 * kRadiusM;
  body.size.z = kHeightM;
  for (const auto& track : tracker_.tracks()) {
    if (!track.confirmed) continue;
    message.tracks.push_back(ros_convert::to_message(track, body));
    const auto walk = walks_.find(track.id);
    message.tracks.back().score = walk != walks_.end() && passes(walk->second) ? 1 : 0;
  }
  return message;
}

}  // namespace extperfc::ros_navigate
