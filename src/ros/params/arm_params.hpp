#pragma once

#include <map>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/arm/depth_obstacles.hpp"
#include "extperfc/arm/grasp.hpp"
#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/object_list.hpp"
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/arm/upright_box.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::ros_params {

/// A trajectory server of the robot and the joints it moves.
struct ControllerParams {
  std::string action;  ///< control_msgs/FollowJointTrajectory
  std::string group;   ///< of the SRDF
};

struct ExecutionParams {
  double monitor_rate_hz{20.0};       ///< checks of the remaining path, [1, 200]
  double follow_tolerance_rad{0.25};  ///< larger deviations end the motion, [0.001, 3]
  double follow_delay_s{0.5};         ///< accepted lag of the robot, [0, 5]
  double start_tolerance_rad{0.05};   ///< accepted distance from a trajectory's start, [0.001, 1]
  double joint_state_timeout_s{1.0};  ///< older joint states are ignored [s of wall time], [0.05, 10]
  double finish_time_s{3.0};          ///< accepted time beyond the trajectory's duration, [0.1, 60]
  double connect_timeout_s{3.0};      ///< wait for a trajectory server [s of wall time], [0, 60]
  double start_delay_s{0.1};          ///< until servers that move together start, [0.01, 2]
  bool robot_state{true};             ///< require robot/state to report an enabled robot
};

struct JogParams {
  double rate_hz{100.0};          ///< of commands, [10, 500]
  double command_timeout_s{0.2};  ///< validity of a jog command, [0.02, 2]
  double velocity_scale{0.3};     ///< of the joints' limits, (0, 1]
};

/// A parallel gripper and the arm that carries it.
struct GripperParams {
  std::string name;          ///< as in the action pick, e.g. left
  std::string group;         ///< of the SRDF, moves the gripper
  std::string tip;           ///< link, see arm::ParallelHand
  std::string finger_joint;  ///< the driven one
  std::string action;        ///< control_msgs/GripperCommand; positions in per cent of the opening
};

struct GraspNodeParams {
  arm::GraspParams grasp;        ///< also lift and approach
  double retreat_m{0.1};         ///< after opening the gripper, [0.01, 0.5]
  double lower_m{0.08};          ///< straight descent before opening the gripper, [0.01, 0.5]
  double effort_percent{0};      ///< of the gripper's force; 0: the gripper's setting, [0, 100]
  double gripper_timeout_s{10};  ///< of wall time, [0.5, 60]
  double slow{0.4};              ///< factor of the velocity on straight paths near objects, (0, 1]
};

struct DepthObstacleMonitorParams {
  bool enabled{false};    ///< add a depth camera's images to the scene
  double rate_hz{10.0};   ///< maximum rate of processed images, [0.1, 60]
  double timeout_s{5.0};  ///< without messages before diagnostics warn [s of wall time], [0.1, 3600]
  arm::DepthObstaclesParams obstacles;
};

struct ObjectMonitorParams {
  bool enabled{false};     ///< add detected objects to the scene
  double min_score{0.3};   ///< detections below are ignored, [0, 1]
  double largest_m{0.25};  ///< detections with a longer edge are ignored, [0.001, 100]
  double timeout_s{5.0};   ///< without messages before diagnostics warn [s of wall time], [0.1, 3600]
  std::map<std::string, arm::UprightKind> shapes;  ///< of classes; others are boxes
  arm::ObjectListParams list;
};

struct ArmNodeParams {
  std::string urdf;  ///< XML of the robot's description
  std::string srdf_file;
  std::string world_frame{"odom"};  ///< stands still while the base drives
  double planning_time_s{5.0};      ///< default of requests, (0, 600]
  double velocity_scale{0.5};       ///< the same, (0, 1]
  double acceleration_scale{0.5};   ///< the same, (0, 1]
  double transform_timeout_s{0.5};  ///< maximum wait for a transform [s of wall time], [0, 10]
  arm::RobotArmsParams robot;
  arm::MotionPipelineParams pipeline;
  std::vector<ControllerParams> controllers;
  ExecutionParams execution;
  JogParams jog;
  GraspNodeParams grasp;
  DepthObstacleMonitorParams depth;
  ObjectMonitorParams objects;
  std::vector<GripperParams> grippers;
};

/// Errors: all problems at once, including unknown keys.
[[nodiscard]] Result<ArmNodeParams> load_arm_params(const ros::NodeHandle& private_handle);

/// Folder of package://extperfc/.
[[nodiscard]] std::string package_folder();

}  // namespace extperfc::ros_params
