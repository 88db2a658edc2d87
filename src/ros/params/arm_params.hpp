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
#include "extperfc/arm/standing_box.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::ros_params {

/// A trajectory server of the robot and the joints it moves.
struct ControllerParams {
  std::string action;  ///< control_msgs/FollowJointTrajectory
  std::string group;   ///< of the SRDF
};

struct ExecutionParams {
  double monitor_rate_hz{20.0};       ///< how often the way ahead is looked at, [1, 200]
  double follow_tolerance_rad{0.25};  ///< a joint farther from the trajectory does not follow, [0.001, 3]
  double follow_delay_s{0.5};         ///< that the robot may lag behind, [0, 5]
  double start_tolerance_rad{0.05};   ///< how far the robot may be from a trajectory's start, [0.001, 1]
  double joint_state_timeout_s{1.0};  ///< older joint states are none [s], [0.05, 10]
  double finish_time_s{3.0};          ///< beyond the trajectory's duration that it may take, [0.1, 60]
  double connect_timeout_s{3.0};      ///< wait for a trajectory server [s of wall time], [0, 60]
  double start_delay_s{0.1};          ///< of motions by several servers, to start together, [0.01, 2]
  bool robot_state{true};             ///< robot/state tells whether the robot is enabled
};

struct JogParams {
  double rate_hz{100.0};          ///< of commands, [10, 500]
  double command_timeout_s{0.2};  ///< a jog command counts for so long, [0.02, 2]
  double velocity_scale{0.3};     ///< of the joints' limits, (0, 1]
};

/// A parallel gripper and the arm that carries it.
struct HandParams {
  std::string name;          ///< as in the action pick, e.g. left
  std::string group;         ///< of the SRDF that moves it
  std::string tip;           ///< link, see arm::ParallelHand
  std::string finger_joint;  ///< the driven one
  std::string action;        ///< control_msgs/GripperCommand; positions in per cent of the opening
};

struct GraspNodeParams {
  arm::GraspParams grasp;        ///< lift and approach too
  double retreat_m{0.1};         ///< back after letting go, [0.01, 0.5]
  double lower_m{0.08};          ///< straight down before letting go, [0.01, 0.5]
  double effort_percent{0};      ///< of the gripper's force; 0: as it is set up, [0, 100]
  double gripper_timeout_s{10};  ///< of wall time, [0.5, 60]
  double slow{0.4};              ///< of the velocity on straight ways near things, (0, 1]
};

struct DepthWatchParams {
  bool enabled{false};    ///< a depth camera's pictures become part of the scene
  double rate_hz{10.0};   ///< of the pictures that are looked at, at most; [0.1, 60]
  double timeout_s{5.0};  ///< silence after which diagnostics warn [s of wall time], [0.1, 3600]
  arm::DepthObstaclesParams obstacles;
};

struct ObjectWatchParams {
  bool enabled{false};      ///< detected objects become part of the scene
  double least_score{0.3};  ///< of detections that count, [0, 1]
  double largest_m{0.25};   ///< longest edge of detections that count, [0.001, 100]
  double timeout_s{5.0};    ///< silence after which diagnostics warn [s of wall time], [0.1, 3600]
  std::map<std::string, arm::StandingKind> shapes;  ///< of classes; others are boxes
  arm::ObjectListParams list;
};

struct ArmNodeParams {
  std::string urdf;  ///< XML of the robot's description
  std::string srdf_file;
  std::string world_frame{"odom"};  ///< stands still while the base drives
  double planning_time_s{5.0};      ///< where a request does not say, (0, 600]
  double velocity_scale{0.5};       ///< the same, (0, 1]
  double acceleration_scale{0.5};   ///< the same, (0, 1]
  double transform_timeout_s{0.5};  ///< wait for a transform [s of wall time], [0, 10]
  arm::RobotArmsParams robot;
  arm::MotionPipelineParams pipeline;
  std::vector<ControllerParams> controllers;
  ExecutionParams execution;
  JogParams jog;
  GraspNodeParams grasp;
  DepthWatchParams depth;
  ObjectWatchParams objects;
  std::vector<HandParams> hands;
};

/// Every problem is reported at once, unknown keys too.
[[nodiscard]] Result<ArmNodeParams> load_arm_params(const ros::NodeHandle& private_handle);

/// Where package://extperfc/ points.
[[nodiscard]] std::string package_folder();

}  // namespace extperfc::ros_params
