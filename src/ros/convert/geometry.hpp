#pragma once

#include <Eigen/Geometry>
#include <boost/array.hpp>
#include <geometry_msgs/Point.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/Vector3.h>
#include <ros/time.h>

#include "extperfc/world/pose.hpp"

/// Core geometry as messages.
namespace extperfc::ros_convert {

inline geometry_msgs::Point to_point(const Eigen::Vector3d& v) {
  geometry_msgs::Point point;
  point.x = v.x();
  point.y = v.y();
  point.z = v.z();
  return point;
}

inline geometry_msgs::Vector3 to_vector(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 vector;
  vector.x = v.x();
  vector.y = v.y();
  vector.z = v.z();
  return vector;
}

inline geometry_msgs::Quaternion to_quaternion(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  geometry_msgs::Quaternion quaternion;
  quaternion.x = q.x();
  quaternion.y = q.y();
  quaternion.z = q.z();
  quaternion.w = q.w();
  return quaternion;
}

inline geometry_msgs::Pose to_message(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position = to_point(pose.translation());
  message.orientation = to_quaternion(pose);
  return message;
}

inline geometry_msgs::Twist to_message(const Twist2& twist) {
  geometry_msgs::Twist message;
  message.linear.x = twist.vx;
  message.linear.y = twist.vy;
  message.angular.z = twist.wz;
  return message;
}

inline geometry_msgs::TransformStamped to_transform(const Pose& target_T_source, const char* target,
                                                    const char* source, const ros::Time& stamp) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = target;
  message.child_frame_id = source;
  message.transform.translation = to_vector(target_T_source.translation());
  message.transform.rotation = to_quaternion(target_T_source);
  return message;
}

/// Covariance of something that moves on a floor: x, y and yaw as given, the rest as good as exact.
inline boost::array<double, 36> planar_covariance(double x, double y, double yaw) {
  constexpr double kExact = 1e-9;
  boost::array<double, 36> covariance{};
  covariance[0] = x;
  covariance[7] = y;
  covariance[14] = covariance[21] = covariance[28] = kExact;
  covariance[35] = yaw;
  return covariance;
}

}  // namespace extperfc::ros_convert
