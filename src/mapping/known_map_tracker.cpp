#include "mapping/known_map_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <Eigen/LU>

#include "mapping/pose_distance.hpp"

namespace extperfc::mapping {

namespace {

constexpr std::size_t kLocalFrames = 40;
constexpr double kLookAroundEveryM = 0.5;
constexpr double kLookAroundEveryRad = 0.4;

/// Distance of two poses [m]; a scanner that looks elsewhere sees other surfaces.
double apart(const Pose2& a, const Pose2& b) {
  constexpr double kMetresPerRad = 1.0;
  return distance(a, b) + kMetresPerRad * yaw_between(a, b);
}

/// Poses that show nearly the same have the same key.
std::tuple<long, long, long> key_of(const Pose2& pose) {
  constexpr double kSameM = 0.3;
  constexpr double kSameRad = 0.3;
  return {std::lround(pose.x / kSameM), std::lround(pose.y / kSameM), std::lround(pose.yaw / kSameRad)};
}

/// The key frames about `pose`, one of each place, the nearest last.
std::vector<std::size_t> frames_about(const Pose2& pose, const std::vector<KeyFrame>& frames,
                                      const std::vector<Pose2>& poses) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (!frames[i].is_thinned()) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return apart(poses[a], pose) < apart(poses[b], pose); });
  std::set<std::tuple<long, long, long>> places;
  std::vector<std::size_t> chosen;
  for (const std::size_t i : order) {
    if (chosen.size() == kLocalFrames) break;
    if (places.insert(key_of(poses[i])).second) chosen.push_back(i);
  }
  std::reverse(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

KnownMapTracker::KnownMapTracker(const OdometryNoise& noise, double minimum_fit, const Pose2& pose,
                                 const Eigen::Matrix3d& covariance)
    : motion_(noise, minimum_fit), tracker_(noise, minimum_fit), covariance_(covariance) {
  tracker_.begin_at(pose);
}

Tracked KnownMapTracker::add(const ScanPoints& points, const std::optional<Pose2>& odom_T_base, double gap_s,
                             const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) {
  look_around(frames, poses);
  const Tracked moved = motion_.add(points, odom_T_base, gap_s);
  Tracked tracked = tracker_.add(points, moved.pose, gap_s);
  tracked.odometry_contradicted = moved.odometry_contradicted;
  const Eigen::Matrix3d step = tracked.information.inverse();
  covariance_ = tracked.matched ? step : Eigen::Matrix3d(covariance_ + step);
  return tracked;
}

void KnownMapTracker::expect_elsewhere() {
  motion_.expect_elsewhere();
  tracker_.expect_elsewhere();
}

void KnownMapTracker::follow(const std::vector<Pose2>& before, const std::vector<Pose2>& after) {
  const auto nearest = std::min_element(before.begin(), before.end(), [&](const Pose2& a, const Pose2& b) {
    return apart(a, pose()) < apart(b, pose());
  });
  tracker_.begin_at(
      compose(after[static_cast<std::size_t>(nearest - before.begin())], between(*nearest, pose())));
  looked_around_at_.reset();
}

void KnownMapTracker::look_around(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses) {
  if (looked_around_at_) {
    const Pose2 since = between(*looked_around_at_, pose());
    if (std::hypot(since.x, since.y) < kLookAroundEveryM && std::abs(since.yaw) < kLookAroundEveryRad) return;
  }
  tracker_.use_as_map(frames, poses, frames_about(pose(), frames, poses));
  looked_around_at_ = pose();
}

}  // namespace extperfc::mapping
