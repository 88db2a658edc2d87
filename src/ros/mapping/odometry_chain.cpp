#include "ros/mapping/odometry_chain.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc {

namespace {

constexpr double kSlackM = 0.3;
constexpr double kSlackRad = 0.3;

/// `motion` with another turn. The robot went along an arc, so a wrong turn bent its way by half of the
/// error.
Pose2 with_turn(const Pose2& motion, double turn_rad) {
  const double bend_rad = 0.5 * wrap_angle(turn_rad - motion.yaw);
  const Pose2 way = compose({0, 0, bend_rad}, {motion.x, motion.y, 0});
  return {way.x, way.y, wrap_angle(turn_rad)};
}

}  // namespace

OdometryChain::Step OdometryChain::next(double stamp_s, const std::optional<Pose2>& odometry,
                                        std::optional<double> imu_yaw_rad) {
  if (!odometry) return {};
  const auto last = last_;
  last_ = Sample{stamp_s, *odometry, imu_yaw_rad};
  if (!last) {
    if (pose_) return {};  // a new beginning: unknown how far from the old end
    pose_ = *odometry;
    return {pose_, false, false};
  }
  Pose2 motion = between(last->odometry, *odometry);
  if (!possible(motion, stamp_s - last->stamp_s)) return {std::nullopt, true, false};
  const bool by_imu = imu_yaw_rad && last->imu_yaw_rad;
  if (by_imu) motion = with_turn(motion, *imu_yaw_rad - *last->imu_yaw_rad);
  pose_ = compose(pose_.value_or(last->odometry), motion);
  return {pose_, false, by_imu};
}

bool OdometryChain::possible(const Pose2& motion, double duration_s) const {
  const double passed_s = std::max(duration_s, 0.0);
  const double way_m = std::hypot(motion.x, motion.y);
  return way_m <= kSlackM + limits_.max_speed_m_s * passed_s &&  // NaN is a jump
         std::abs(motion.yaw) <= kSlackRad + limits_.max_turn_rad_s * passed_s;
}

}  // namespace extperfc
