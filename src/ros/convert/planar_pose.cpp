#include "ros/convert/planar_pose.hpp"

#include <array>
#include <cmath>

namespace extperfc::ros_convert {

namespace {

geometry_msgs::Quaternion about_z(double yaw_rad) {
  geometry_msgs::Quaternion q;
  q.z = std::sin(yaw_rad / 2);
  q.w = std::cos(yaw_rad / 2);
  return q;
}

Result<Pose2> to_pose2(double x, double y, double z, const geometry_msgs::Quaternion& q) {
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!std::isfinite(x + y + z) || !std::isfinite(square))
    return fail(ErrorCode::kInvalidArgument, "the pose has values that are not finite");
  if (square < 1e-12)
    return fail(ErrorCode::kInvalidArgument,
                "the pose's quaternion has length zero; no rotation is x = y = z = 0, w = 1");
  const double yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
  return Pose2{x, y, yaw};
}

constexpr std::array<std::size_t, 3> kPlanar{0, 1, 5};  // x, y and yaw among x, y, z, roll, pitch, yaw

}  // namespace

std::string without_slash(const std::string& frame) {
  return frame.substr(!frame.empty() && frame[0] == '/' ? 1 : 0);
}

geometry_msgs::Pose to_pose_message(const Pose2& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation = about_z(pose.yaw);
  return message;
}

geometry_msgs::Transform to_transform_message(const Pose2& pose) {
  geometry_msgs::Transform message;
  message.translation.x = pose.x;
  message.translation.y = pose.y;
  message.rotation = about_z(pose.yaw);
  return message;
}

Result<Pose2> to_pose2(const geometry_msgs::Pose& pose) {
  return to_pose2(pose.position.x, pose.position.y, pose.position.z, pose.orientation);
}

Result<Pose2> to_pose2(const geometry_msgs::Transform& transform) {
  return to_pose2(transform.translation.x, transform.translation.y, transform.translation.z,
                  transform.rotation);
}

boost::array<double, 36> to_covariance_message(const Eigen::Matrix3d& covariance) {
  boost::array<double, 36> message{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      message[6 * kPlanar[row] + kPlanar[column]] =
          covariance(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  return message;
}

Eigen::Matrix3d to_covariance(const boost::array<double, 36>& covariance) {
  Eigen::Matrix3d planar;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      planar(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
          covariance[6 * kPlanar[row] + kPlanar[column]];
  return planar;
}

}  // namespace extperfc::ros_convert
