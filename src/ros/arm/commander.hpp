#pragma once

#include <optional>
#include <string>

#include <extperfc/ArmRequest.h>
#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/motion_pipeline.hpp"

#include "ros/arm/ending.hpp"
#include "ros/arm/executor.hpp"
#include "ros/arm/frame_finder.hpp"
#include "ros/arm/robot_watch.hpp"
#include "ros/arm/scene_keeper.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::arm_node {

/// What parts of the node share; all of it is thread-safe but the executor, which one motion has at a time.
struct Shared {
  const ros_params::ArmNodeParams& params;
  const arm::RobotArms& arms;
  RobotWatch& watch;
  FrameFinder& frames;
  SceneKeeper& scene;
  Executor& executor;
};

/// How a motion went.
struct Moved {
  Ending ending;
  trajectory_msgs::JointTrajectory trajectory;  ///< executed last
  double fraction{0};
  double executed{0};
  std::uint32_t replans{0};
};

/// Reads requests, plans and moves. Not thread-safe: each server of actions has its own.
class Commander {
 public:
  explicit Commander(const Shared& shared)
      : shared_(shared), pipeline_(shared.arms, shared.params.pipeline) {}

  /// From the robot's present state, unless the message has a start. Endings name what is wrong.
  [[nodiscard]] tl::expected<arm::MotionRequest, Ending> read(const extperfc::ArmRequest& message) const;

  /// In the present scene, with the contacts that `hooks.allow` allows.
  [[nodiscard]] arm::MotionOutcome plan(const arm::MotionRequest& request, const Hooks& hooks = {});

  /// Plans from where the robot is and executes; where the way becomes blocked, looks for another one up to
  /// `replans` times.
  [[nodiscard]] Moved move(arm::MotionRequest request, std::uint32_t replans, const Hooks& hooks);
  [[nodiscard]] Moved execute(const trajectory_msgs::JointTrajectory& trajectory, const Hooks& hooks);

  [[nodiscard]] arm::MotionPipeline& pipeline() { return pipeline_; }
  [[nodiscard]] const Shared& shared() const { return shared_; }

 private:
  Shared shared_;
  arm::MotionPipeline pipeline_;
};

}  // namespace extperfc::arm_node
