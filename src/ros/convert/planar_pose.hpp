#pragma once

#include <string>

#include <Eigen/Core>
#include <boost/array.hpp>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_convert {

/// A frame's name as tf2 knows it: without tf's leading slash.
[[nodiscard]] std::string without_slash(const std::string& frame);

[[nodiscard]] geometry_msgs::Pose to_pose_message(const Pose2& pose);
[[nodiscard]] geometry_msgs::Transform to_transform_message(const Pose2& pose);

/// What of a pose lies on the floor. Errors: values that are not finite, a quaternion of length zero.
[[nodiscard]] Result<Pose2> to_pose2(const geometry_msgs::Pose& pose);
[[nodiscard]] Result<Pose2> to_pose2(const geometry_msgs::Transform& transform);

/// Rows and columns x, y, yaw to and from the 6 x 6 of geometry_msgs/PoseWithCovariance.
[[nodiscard]] boost::array<double, 36> to_covariance_message(const Eigen::Matrix3d& covariance);
[[nodiscard]] Eigen::Matrix3d to_covariance(const boost::array<double, 36>& covariance);

}  // namespace extperfc::ros_convert
