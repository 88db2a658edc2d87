#include "ros/mapping/odometry_chain.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::ros_mapping {

namespace {

constexpr double kSlackM = 0.3;
constexpr double kSlackRad = 0.3;

/// `motion` with another rotation. The robot moved along an arc, so an error of the rotation rotates the
/// translation by half of that error.
Pose2 with_yaw(const Pose2& motion, double yaw_rad) {
  const double heading_change_rad = 0.5 * wrap_angle(yaw_rad - motion.yaw);
  const Pose2 translation = compose({0, 0, heading_change_rad}, {motion.x, motion.y, 0});
  return {translation.x, translation.y, wrap_angle(yaw_rad)};
}

}  // namespace

OdometryChain::Step OdometryChain::next(double stamp_s, const std::optional<Pose2>& odometry,
                                        std::optional<double> imu_yaw_rad) {
  if (!odometry) return {};
  const auto last = last_;
  last_ = Sample{stamp_s, *odometry, imu_yaw_rad};
  if (!last) {
    if (pose_) return {};  // restarted: the motion since the last pose is unknown
    pose_ = *odometry;
    return {pose_, false, false};
  }
  Pose2 motion = between(last->odometry, *odometry);
  if (!possible(motion, stamp_s - last->stamp_s)) return {std::nullopt, true, false};
  const bool by_imu = imu_yaw_rad && last->imu_yaw_rad;
  if (by_imu) motion = with_yaw(motion, *imu_yaw_rad - *last->imu_yaw_rad);
  pose_ = compose(pose_.value_or(last->odometry), motion);
  return {pose_, false, by_imu};
}

bool OdometryChain::possible(const Pose2& motion, double duration_s) const {
  const double passed_s = std::max(duration_s, 0.0);
  const double distance_m = std::hypot(motion.x, motion.y);
  return distance_m <= kSlackM + limits_.max_speed_m_s * passed_s &&  // NaN is a jump
         std::abs(motion.yaw) <= kSlackRad + limits_.max_yaw_rate_rad_s * passed_s;
}

}  // namespace extperfc::ros_mapping
