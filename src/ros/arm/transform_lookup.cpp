#include "ros/arm/transform_lookup.hpp"

#include <tf2_eigen/tf2_eigen.h>

#include "ros/convert/arm.hpp"

namespace extperfc::ros_arm {

using arm::ArmCode;

tl::expected<Pose, Status> TransformLookup::root_T_frame(const std::string& given,
                                                         const ros::Time& stamp) const {
  const std::string frame = !given.empty() && given.front() == '/' ? given.substr(1) : given;
  const auto& root = arms_.root_link();
  if (frame.empty() || frame == root) return Pose::Identity();
  if (stamp.isZero() && is_link(frame)) {
    const auto positions = robot_state_.positions();
    if (!positions) return tl::unexpected(positions.error());
    return arms_.link_pose(frame, *positions).value();
  }
  try {
    // Waits by wall time: tf's own wait would not end while simulated time is paused.
    const auto until = ros::WallTime::now() + ros::WallDuration(timeout_s_);
    while (!buffer_.canTransform(root, frame, stamp) && ros::WallTime::now() < until && ros::ok())
      ros::WallDuration(0.01).sleep();
    return Pose(tf2::transformToEigen(buffer_.lookupTransform(root, frame, stamp)).matrix());
  } catch (const tf2::TransformException& error) {
    return failure(ArmCode::kUnknownFrame,
                   "no transform from " + root + " to the frame '" + frame + "': " + error.what());
  }
}

tl::expected<Pose, Status> TransformLookup::root_T_pose(const geometry_msgs::PoseStamped& pose) const {
  const auto frame_T_pose = ros_convert::to_pose(pose.pose);
  if (!frame_T_pose) return failure(ArmCode::kInvalidRequest, frame_T_pose.error().message);
  auto root_T_frame = this->root_T_frame(pose.header.frame_id, pose.header.stamp);
  if (!root_T_frame) return root_T_frame;
  return *root_T_frame * *frame_T_pose;
}

}  // namespace extperfc::ros_arm
