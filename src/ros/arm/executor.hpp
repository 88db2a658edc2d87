#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <ros/node_handle.h>
#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/timed_path.hpp"

#include "ros/arm/ending.hpp"
#include "ros/arm/robot_watch.hpp"
#include "ros/arm/scene_keeper.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::arm_node {

/// What a motion reports to and asks of whoever wanted it.
struct Hooks {
  /// Why it shall stop; asked at the monitor's rate. May be empty.
  std::function<std::optional<Ending>()> interrupted;
  /// Share of the trajectory in [0, 1]. May be empty.
  std::function<void(const std::string& stage, double executed)> progress;
  /// Contacts that this motion may have, allowed in the present world. May be empty.
  std::function<void(arm::CollisionWorld& world)> allow;
  /// Called with every trajectory before it is executed. May be empty.
  std::function<void(const trajectory_msgs::JointTrajectory& trajectory)> planned;
};

struct Execution {
  Ending ending;
  double executed{0};  ///< share of the trajectory's time, [0, 1]
};

/// Has the robot's trajectory servers follow a path, and watches: the way ahead whenever the scene changes,
/// the joints, the robot's state. Whatever goes wrong, all arms stop before run() returns. One motion at a
/// time: callers see to that.
///
/// A path for several servers is proven free for joints that move together, so all of them get the same start
/// time (header.stamp, on the robot's clock), `start_delay_s` ahead. A single server starts at once (stamp
/// 0).
class Executor {
 public:
  Executor(const ros::NodeHandle& handle, const arm::RobotArms& arms, const RobotWatch& watch,
           const SceneKeeper& scene, const ros_params::ExecutionParams& params,
           const std::vector<ros_params::ControllerParams>& controllers);

  /// The pipeline is the caller's own. The path's joints are those of one of the robot's groups.
  [[nodiscard]] Execution run(const arm::TimedPath& path, arm::MotionPipeline& pipeline, const Hooks& hooks);

  /// Names of groups and actions that fit; what does not is an error. For the node's start.
  [[nodiscard]] Result<void> check() const;

 private:
  using Client = actionlib::SimpleActionClient<control_msgs::FollowJointTrajectoryAction>;
  struct Controller {
    std::string action;
    std::string group;
    std::unique_ptr<Client> client;
  };
  class Motion;

  [[nodiscard]] tl::expected<std::vector<Controller*>, Ending> controllers_of(const arm::TimedPath& path);
  [[nodiscard]] tl::expected<void, Ending> connect(const Controller& controller) const;

  const arm::RobotArms& arms_;
  const RobotWatch& watch_;
  const SceneKeeper& scene_;
  const ros_params::ExecutionParams params_;
  std::vector<Controller> controllers_;
};

}  // namespace extperfc::arm_node
