#include "extperfc/world/pose.hpp"

#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc {

Pose make_pose(const Eigen::Vector3d& xyz_m, const Eigen::Vector3d& rpy_rad) {
  Pose pose = Pose::Identity();
  pose.translation() = xyz_m;
  pose.linear() = (Eigen::AngleAxisd(rpy_rad.z(), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy_rad.y(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy_rad.x(), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Pose to_pose(const Pose2& pose) {
  return make_pose({pose.x, pose.y, 0.0}, {0.0, 0.0, pose.yaw});
}

Pose2 to_pose2(const Pose& pose) {
  const auto& rotation = pose.linear();
  return {pose.translation().x(), pose.translation().y(), std::atan2(rotation(1, 0), rotation(0, 0))};
}

double wrap_angle(double angle_rad) {
  const double wrapped = std::remainder(angle_rad, kTwoPi);
  return wrapped <= -kPi ? wrapped + kTwoPi : wrapped;
}

bool is_finite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

bool is_finite(const Twist2& twist) {
  return std::isfinite(twist.vx) && std::isfinite(twist.vy) && std::isfinite(twist.wz);
}

bool is_zero(const Twist2& twist) {
  return twist.vx == 0 && twist.vy == 0 && twist.wz == 0;
}

double distance_m(const Pose2& a, const Pose2& b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

Pose2 compose(const Pose2& a_T_b, const Pose2& b_T_c) {
  const double c = std::cos(a_T_b.yaw);
  const double s = std::sin(a_T_b.yaw);
  return {a_T_b.x + c * b_T_c.x - s * b_T_c.y, a_T_b.y + s * b_T_c.x + c * b_T_c.y,
          wrap_angle(a_T_b.yaw + b_T_c.yaw)};
}

Pose2 inverse(const Pose2& pose) {
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  return {-c * pose.x - s * pose.y, s * pose.x - c * pose.y, wrap_angle(-pose.yaw)};
}

Pose2 between(const Pose2& a, const Pose2& b) {
  return compose(inverse(a), b);
}

Pose2 advance(const Pose2& pose, const Twist2& twist, double duration_s) {
  const double yaw = twist.wz * duration_s;
  // sin(a)/a and (1 - cos(a))/a, by their series where the quotient loses digits.
  const bool small = std::abs(yaw) < 1e-6;
  const double along = small ? 1 - yaw * yaw / 6 : std::sin(yaw) / yaw;
  const double across = small ? yaw / 2 : (1 - std::cos(yaw)) / yaw;
  const double dx = (twist.vx * along - twist.vy * across) * duration_s;
  const double dy = (twist.vx * across + twist.vy * along) * duration_s;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  return {pose.x + c * dx - s * dy, pose.y + s * dx + c * dy, wrap_angle(pose.yaw + yaw)};
}

}  // namespace extperfc
