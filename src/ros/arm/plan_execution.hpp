#pragma once

#include <optional>
#include <string>

#include <extperfc/ArmRequest.h>
#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/motion_pipeline.hpp"

#include "ros/arm/executor.hpp"
#include "ros/arm/planning_scene.hpp"
#include "ros/arm/robot_state_monitor.hpp"
#include "ros/arm/status.hpp"
#include "ros/arm/transform_lookup.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::ros_arm {

/// Shared by the parts of the node. All members are thread-safe except the executor, which executes one
/// motion at a time.
struct Shared {
  const ros_params::ArmNodeParams& params;
  const arm::RobotArms& arms;
  RobotStateMonitor& robot_state;
  TransformLookup& transforms;
  PlanningScene& scene;
  Executor& executor;
};

/// A number of a message, in which 0 stands for the default.
[[nodiscard]] inline double value_or_default(double value, double default_value) {
  return value == 0.0 ? default_value : value;
}

/// Result of a motion.
struct Moved {
  Status status;
  trajectory_msgs::JointTrajectory trajectory;  ///< executed last
  double fraction{0};
  double executed{0};
  std::uint32_t replans{0};
};

/// Converts requests, plans and executes them. Not thread-safe: each action server has a separate one.
class PlanExecution {
 public:
  explicit PlanExecution(const Shared& shared)
      : shared_(shared), pipeline_(shared.arms, shared.params.pipeline) {}

  /// Starts at the robot's present state unless the message has a start. Errors name the invalid part.
  [[nodiscard]] tl::expected<arm::MotionRequest, Status> read(const extperfc::ArmRequest& message) const;

  /// The robot's present joint positions, replaced by those of the message. Errors name the joint.
  [[nodiscard]] tl::expected<arm::JointPositions, Status> read_start(
      const sensor_msgs::JointState& message) const;

  /// Plans in the present scene, with the contacts that `callbacks.allow` permits. While the start is in
  /// collision and the scene has what a depth camera saw, waits up to 1 s for images that show the robot
  /// there.
  [[nodiscard]] arm::MotionOutcome plan(const arm::MotionRequest& request,
                                        const MotionCallbacks& callbacks = {});

  /// Plans from the robot's present state and executes. When the path becomes blocked, plans again up to
  /// `replans` times.
  [[nodiscard]] Moved move(arm::MotionRequest request, std::uint32_t replans,
                           const MotionCallbacks& callbacks);
  [[nodiscard]] Moved execute(const trajectory_msgs::JointTrajectory& trajectory,
                              const MotionCallbacks& callbacks);

  [[nodiscard]] arm::MotionPipeline& pipeline() { return pipeline_; }
  [[nodiscard]] const Shared& shared() const { return shared_; }

 private:
  Shared shared_;
  arm::MotionPipeline pipeline_;
};

}  // namespace extperfc::ros_arm
