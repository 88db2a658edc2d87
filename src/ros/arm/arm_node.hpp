#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include <extperfc/ApplyScene.h>
#include <extperfc/CheckArmState.h>
#include <extperfc/GetScene.h>
#include <extperfc/MoveArmAction.h>
#include <extperfc/PlanAction.h>
#include <extperfc/SolveArmIk.h>
#include <ros/node_handle.h>
#include <std_srvs/Empty.h>
#include <std_srvs/Trigger.h>

#include "ros/arm/action_runner.hpp"
#include "ros/arm/arms_lease.hpp"
#include "ros/arm/commander.hpp"
#include "ros/arm/depth_watch.hpp"
#include "ros/arm/grasper.hpp"
#include "ros/arm/jog_server.hpp"
#include "ros/arm/object_watch.hpp"
#include "ros/health/reporter.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::arm_node {

/// Plans and executes motions of the robot's arms.
///
/// Actions (result codes: extperfc/ArmCode):
///   plan        extperfc/PlanAction: a trajectory, nothing moves
///   move_arm    extperfc/MoveArmAction: plans and executes, or executes a trajectory. A newer goal, also of
///               another of the actions that move, stops the older one, which ends preempted
///   pick        extperfc/PickAction: grasps a thing of the scene and lifts it
///   place       extperfc/PlaceAction: puts it down
/// Services:
///   arm/apply_scene   extperfc/ApplyScene: what arms must not touch; attached things
///   arm/get_scene     extperfc/GetScene
///   arm/check_state   extperfc/CheckArmState
///   arm/solve_ik      extperfc/SolveArmIk
///   arm/stop          std_srvs/Trigger: whatever moves stops, its goal ends as cancelled
///   arm/clear_depth   std_srvs/Empty: what the depth camera saw is forgotten, as when apply_scene removes
///   all
/// Subscribes:
///   robot/joint_states   sensor_msgs/JointState
///   robot/state          baxter_core_msgs/AssemblyState, with execution/robot_state
///   /tf, /tf_static      for poses in frames that are no links of the robot
///   a depth camera's pictures, with depth/enabled: see DepthWatch
///   a detector's objects, with objects/enabled: see ObjectWatch
/// Publishes:
///   arm/display_trajectory   trajectory_msgs/JointTrajectory, latched: planned last
///   arm/markers              visualization_msgs/MarkerArray, latched: the scene, when it changes
///   diagnostics              diagnostic_msgs/DiagnosticArray
/// Jogging: topics arm/<hand>/jog_joints, jog_twist and jog_status, see JogServer
/// Uses the actions robot/limb/<side>/follow_joint_trajectory (control_msgs/FollowJointTrajectory) and
///   robot/end_effector/<side>_gripper/gripper_action (control_msgs/GripperCommand).
/// Parameters (private; unknown keys are refused): config/arm.yaml has them with units and ranges. The robot
///   is the parameter robot_description, its groups are those of an SRDF file.
/// Frames: poses may be in any frame that tf joins to the robot's root link. Things of the scene stand still
///   in world_frame.
/// Diagnostics: WARN without joint states, while the robot is not enabled; what the last request came to.
/// Threads: one for each action, services and callbacks in the node handle's queue, which needs more than
///   one thread.
class ArmNode {
 public:
  /// Errors: every bad parameter at once, a robot or SRDF that cannot be read or does not fit.
  [[nodiscard]] static Result<std::unique_ptr<ArmNode>> make(const ros::NodeHandle& handle,
                                                             const ros::NodeHandle& private_handle,
                                                             const std::string& name);
  ~ArmNode();
  ArmNode(const ArmNode&) = delete;
  ArmNode& operator=(const ArmNode&) = delete;

 private:
  ArmNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
          const ros_params::ArmNodeParams& params, arm::RobotArms arms, const std::string& name);
  void advertise();

  Ending plan(const extperfc::PlanGoal& goal, const Hooks& hooks, extperfc::PlanResult& result);
  Ending move(const extperfc::MoveArmGoal& goal, const Hooks& hooks, extperfc::MoveArmResult& result);
  Ending pick(const extperfc::PickGoal& goal, const Hooks& hooks, extperfc::PickResult& result);
  Ending place(const extperfc::PlaceGoal& goal, const Hooks& hooks, extperfc::PlaceResult& result);
  /// The hooks, and what else ends a motion: a newer one, and arm/stop.
  [[nodiscard]] Hooks with_stops(const Hooks& hooks, const ArmsLease::Hold& hold);
  void note(const char* what, const Ending& ending);

  bool on_apply_scene(extperfc::ApplyScene::Request& request, extperfc::ApplyScene::Response& response);
  bool on_get_scene(extperfc::GetScene::Request&, extperfc::GetScene::Response& response);
  bool on_check_state(extperfc::CheckArmState::Request& request, extperfc::CheckArmState::Response& response);
  bool on_solve_ik(extperfc::SolveArmIk::Request& request, extperfc::SolveArmIk::Response& response);
  bool on_clear_depth(std_srvs::Empty::Request&, std_srvs::Empty::Response&);
  bool on_stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  /// After every change but the grasper's own and the depth camera's.
  void on_scene_changed();
  void publish_scene();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  const ros_params::ArmNodeParams params_;
  const arm::RobotArms arms_;
  RobotWatch watch_;
  FrameFinder frames_;
  SceneKeeper scene_;
  Executor executor_;
  ArmsLease lease_;
  std::atomic<std::uint64_t> stops_{0};  ///< calls of arm/stop
  Commander planner_;                    ///< of the action plan
  Commander mover_;                      ///< of the actions that move, under the lease
  std::mutex service_mutex_;
  Commander server_;  ///< of services, under service_mutex_

  std::mutex note_mutex_;
  std::string last_;
  bool last_failed_{false};

  ros::Publisher trajectory_publisher_;
  ros::Publisher marker_publisher_;
  std::unique_ptr<DepthWatch> depth_;     ///< nothing without depth/enabled
  std::unique_ptr<ObjectWatch> objects_;  ///< nothing without objects/enabled
  std::vector<ros::ServiceServer> services_;
  health::Reporter reporter_;
  std::unique_ptr<ActionRunner<extperfc::PlanAction>> plan_action_;
  std::vector<std::unique_ptr<JogServer>> joggers_;
  std::unique_ptr<Grasper> grasper_;  ///< under the lease
  std::unique_ptr<ActionRunner<extperfc::MoveArmAction>> move_action_;
  std::unique_ptr<ActionRunner<extperfc::PickAction>> pick_action_;
  std::unique_ptr<ActionRunner<extperfc::PlaceAction>> place_action_;
};

}  // namespace extperfc::arm_node
