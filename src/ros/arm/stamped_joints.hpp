#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>

#include <ros/node_handle.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/arm/joint_history.hpp"
#include "extperfc/arm/robot_arms.hpp"

namespace extperfc::ros_arm {

/// Posture of the robot when an image was taken: a collision model of the arms and grippers, and a history of
/// their joint positions.
///
/// Subscribes: robot/joint_states   sensor_msgs/JointState
/// Thread-safe.
class StampedJoints {
 public:
  /// Errors: a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<StampedJoints>> make(const arm::RobotArms& arms);

  /// Subscribes. Call once.
  void start(ros::NodeHandle handle);
  /// Ends all waits.
  void close();

  /// Of the arms' joints, and those of the grippers up to kMaxJoints.
  [[nodiscard]] const arm::CollisionModel& model() const { return model_; }
  /// Positions of the model's joints; waits up to 0.2 s of wall time for joint states as new as the stamp.
  /// Joints of grippers that were never published are at 0 or their nearest limit. Errors: a joint of an arm
  /// was never published, no joint states at that time.
  [[nodiscard]] Result<arm::JointVector> at(const ros::Time& stamp);
  /// -infinity before the first one.
  [[nodiscard]] double newest_s() const;

 private:
  StampedJoints(const arm::RobotArms& arms, const arm::CollisionModel& model);
  void on_joints(const sensor_msgs::JointStateConstPtr& message);

  const arm::CollisionModel model_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::condition_variable changed_;
  arm::JointHistory history_;
  bool closing_{false};
  ros::Subscriber subscriber_;
};

}  // namespace extperfc::ros_arm
