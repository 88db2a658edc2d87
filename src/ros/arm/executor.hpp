#pragma once

#include <memory>
#include <string>
#include <vector>

#include <actionlib/client/simple_action_client.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
#include <ros/node_handle.h>

#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/timed_path.hpp"

#include "ros/arm/motion_callbacks.hpp"
#include "ros/arm/planning_scene.hpp"
#include "ros/arm/robot_state_monitor.hpp"
#include "ros/arm/status.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::ros_arm {

struct Execution {
  Status status;
  double executed{0};  ///< fraction of the trajectory's time, [0, 1]
};

/// Sends a path to the robot's trajectory servers and monitors its execution: the remaining path whenever the
/// scene changes, the joints, the robot's state. On any failure all arms stop before run() returns. Callers
/// run one motion at a time.
///
/// A path for several servers is proven free for joints that move together, so all of them get the same start
/// time (header.stamp, on the robot's clock), `start_delay_s` ahead. A single server starts at once (stamp
/// 0).
class Executor {
 public:
  Executor(const ros::NodeHandle& handle, const arm::RobotArms& arms, const RobotStateMonitor& robot_state,
           const PlanningScene& scene, const ros_params::ExecutionParams& params,
           const std::vector<ros_params::ControllerParams>& controllers);

  /// `pipeline` is used by this call only. The path's joints are those of one of the robot's groups.
  [[nodiscard]] Execution run(const arm::TimedPath& path, arm::MotionPipeline& pipeline,
                              const MotionCallbacks& callbacks);

  /// Checks that the controllers' groups exist; called when the node starts.
  [[nodiscard]] Result<void> check() const;

 private:
  using Client = actionlib::SimpleActionClient<control_msgs::FollowJointTrajectoryAction>;
  struct Controller {
    std::string action;
    std::string group;
    std::unique_ptr<Client> client;
  };
  class Motion;

  [[nodiscard]] tl::expected<std::vector<Controller*>, Status> controllers_of(const arm::TimedPath& path);
  [[nodiscard]] tl::expected<void, Status> connect(const Controller& controller) const;

  const arm::RobotArms& arms_;
  const RobotStateMonitor& robot_state_;
  const PlanningScene& scene_;
  const ros_params::ExecutionParams params_;
  std::vector<Controller> controllers_;
};

}  // namespace extperfc::ros_arm
