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
#include "ros/arm/depth_obstacle_monitor.hpp"
#include "ros/arm/grasper.hpp"
#include "ros/arm/jog_server.hpp"
#include "ros/arm/object_monitor.hpp"
#include "ros/arm/plan_execution.hpp"
#include "ros/health/reporter.hpp"
#include "ros/params/arm_params.hpp"

namespace extperfc::ros_arm {

/// Plans and executes motions of the robot's arms, grasps and places objects.
///
/// Subscribes:
///   robot/joint_states  sensor_msgs/JointState
///   robot/state         baxter_core_msgs/AssemblyState, with execution/robot_state
///   /tf, /tf_static     tf2_msgs/TFMessage, for poses in frames that are not links of the robot
/// Publishes:
///   arm/display_trajectory  trajectory_msgs/JointTrajectory, latched: the last plan
///   arm/markers             visualization_msgs/MarkerArray, latched: the scene, after every change
///   diagnostics             diagnostic_msgs/DiagnosticArray
/// Services:
///   arm/apply_scene  extperfc/ApplyScene: changes collision objects and attached objects
///   arm/get_scene    extperfc/GetScene
///   arm/check_state  extperfc/CheckArmState
///   arm/solve_ik     extperfc/SolveArmIk
///   arm/stop         std_srvs/Trigger: stops all motions; their goals end as cancelled
///   arm/clear_depth  std_srvs/Empty: clears what the depth camera saw, as does arm/apply_scene with REMOVE
///                    of all objects
/// Actions (result codes: extperfc/ArmCode):
///   plan      extperfc/PlanAction: plans a trajectory without moving
///   move_arm  extperfc/MoveArmAction: plans and executes, or executes a trajectory. A newer goal, also of
///             another of the actions that move, stops the older one, which ends preempted
///   pick      extperfc/PickAction: grasps an object of the scene and lifts it
///   place     extperfc/PlaceAction: places the held object
/// Calls:
///   robot/limb/<side>/follow_joint_trajectory         control_msgs/FollowJointTrajectory (action)
///   robot/end_effector/<side>_gripper/gripper_action  control_msgs/GripperCommand (action)
/// Parts: JogServer, DepthObstacleMonitor, ObjectMonitor
/// Parameters: config/arm.yaml. The robot is the parameter robot_description, its groups are those of an SRDF
///   file.
/// Frames: poses may be in any frame that tf connects to the robot's root link. Objects of the scene stand
///   still in world_frame.
/// Diagnostics: WARN without joint states and while the robot is not enabled; result of the last request.
/// Threads: one for each action, services and callbacks in the node handle's queue, which needs more than one
///   thread.
class ArmNode {
 public:
  /// Errors: all invalid parameters at once, a robot or SRDF that cannot be read or does not match.
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

  Status plan(const extperfc::PlanGoal& goal, const MotionCallbacks& callbacks, extperfc::PlanResult& result);
  Status move(const extperfc::MoveArmGoal& goal, const MotionCallbacks& callbacks,
              extperfc::MoveArmResult& result);
  Status pick(const extperfc::PickGoal& goal, const MotionCallbacks& callbacks, extperfc::PickResult& result);
  Status place(const extperfc::PlaceGoal& goal, const MotionCallbacks& callbacks,
               extperfc::PlaceResult& result);
  /// The callbacks, with a token that a newer motion and arm/stop cancel, too.
  [[nodiscard]] MotionCallbacks with_stops(const MotionCallbacks& callbacks, const ArmsLease::Hold& hold);
  void note(const char* what, const Status& status);

  bool on_apply_scene(extperfc::ApplyScene::Request& request, extperfc::ApplyScene::Response& response);
  bool on_get_scene(extperfc::GetScene::Request&, extperfc::GetScene::Response& response);
  bool on_check_state(extperfc::CheckArmState::Request& request, extperfc::CheckArmState::Response& response);
  bool on_solve_ik(extperfc::SolveArmIk::Request& request, extperfc::SolveArmIk::Response& response);
  bool on_clear_depth(std_srvs::Empty::Request&, std_srvs::Empty::Response&);
  bool on_stop(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  /// Called after changes by services and detections, not by the grasper or the depth camera.
  void on_scene_changed();
  void publish_scene();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  const ros_params::ArmNodeParams params_;
  const arm::RobotArms arms_;
  RobotStateMonitor robot_state_;
  TransformLookup transforms_;
  PlanningScene scene_;
  Executor executor_;
  ArmsLease lease_;
  std::atomic<std::uint64_t> stops_{0};  ///< calls of arm/stop
  PlanExecution planner_;                ///< of the action plan
  PlanExecution motion_execution_;       ///< of the actions that move, under the lease
  std::mutex service_mutex_;
  PlanExecution server_;  ///< of services, under service_mutex_

  std::mutex note_mutex_;
  std::string last_;
  bool last_failed_{false};

  ros::Publisher trajectory_publisher_;
  ros::Publisher marker_publisher_;
  std::unique_ptr<DepthObstacleMonitor> depth_;  ///< nullptr without depth/enabled
  std::unique_ptr<ObjectMonitor> objects_;       ///< nullptr without objects/enabled
  std::vector<ros::ServiceServer> services_;
  ros_health::Reporter reporter_;
  std::unique_ptr<ActionRunner<extperfc::PlanAction>> plan_action_;
  std::vector<std::unique_ptr<JogServer>> joggers_;
  std::unique_ptr<Grasper> grasper_;  ///< under the lease
  std::unique_ptr<ActionRunner<extperfc::MoveArmAction>> move_action_;
  std::unique_ptr<ActionRunner<extperfc::PickAction>> pick_action_;
  std::unique_ptr<ActionRunner<extperfc::PlaceAction>> place_action_;
};

}  // namespace extperfc::ros_arm
