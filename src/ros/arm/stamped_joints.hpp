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

namespace extperfc::arm_node {

/// The robot as it stood when a picture was taken: a collision model of all its joints that matter, and their
/// positions in the last seconds.
///
/// Subscribes: robot/joint_states   sensor_msgs/JointState
/// Thread-safe.
class StampedJoints {
 public:
  /// Errors: a robot without collision shapes that can be read.
  [[nodiscard]] static Result<std::unique_ptr<StampedJoints>> make(const arm::RobotArms& arms);

  /// Once: subscribes.
  void start(ros::NodeHandle handle);
  /// Nobody is to wait any more.
  void close();

  /// The arms' joints, and those of the hands as far as there is room.
  [[nodiscard]] const arm::CollisionModel& model() const { return model_; }
  /// Of the model's joints; waits for joint states as new as the stamp, 0.2 s of wall time at most. Joints of
  /// hands that were not heard of count as at 0, or their nearest limit. Errors: an arm's joint was not heard
  /// of, nothing is known of that time.
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

}  // namespace extperfc::arm_node
