#include "ros/robot/robot_interface.hpp"

#include <array>

#include "ros/robot/arm_motion.hpp"
#include "ros/robot/assembly_interface.hpp"
#include "ros/robot/gripper_action.hpp"
#include "ros/robot/gripper_interface.hpp"
#include "ros/robot/head_interface.hpp"
#include "ros/robot/joint_state_publisher.hpp"
#include "ros/robot/limb_interface.hpp"
#include "ros/robot/trajectory_action.hpp"
#include "ros/robot/tuck_service.hpp"

namespace extperfc::ros_robot {

using ros_params::RobotInterfaceParams;

/// Everything of one side.
struct RobotInterface::Arm {
  Arm(const ros::NodeHandle& handle, ros_simulate::SimHost& host, simulate::Side side,
      const RobotInterfaceParams& params)
      : motion(host, side, params.trajectory),
        limb(handle, host, side, motion, params.state_rate_hz),
        trajectory_action(handle, host, side, motion, params.feedback_rate_hz),
        gripper(handle, host, side, params.state_rate_hz),
        gripper_action(
            handle, host, side,
            {params.gripper_tolerance_percent, params.gripper_timeout_s, params.feedback_rate_hz}) {}

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
    motion.after_step(simulator, stamp);
    limb.after_step(simulator, stamp);
    trajectory_action.after_step(stamp);
    gripper.after_step(simulator, stamp);
    gripper_action.after_step(simulator, stamp);
  }

  ArmMotion motion;
  LimbInterface limb;
  TrajectoryAction trajectory_action;
  GripperInterface gripper;
  GripperAction gripper_action;
};

struct RobotInterface::Parts {
  Parts(const ros::NodeHandle& handle, ros_simulate::SimHost& host, const RobotInterfaceParams& params)
      : joints(handle, host, params.joint_state_rate_hz),
        assembly(handle, host, params.state_rate_hz),
        head(handle, host, params.state_rate_hz),
        left(handle, host, simulate::Side::kLeft, params),
        right(handle, host, simulate::Side::kRight, params),
        tuck(handle, host, {&left.motion, &right.motion},
             {params.tuck_speed_rad_s, params.tuck_accel_rad_s2}) {}

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
    joints.after_step(simulator, stamp);
    assembly.after_step(simulator, stamp);
    head.after_step(simulator, stamp);
    left.after_step(simulator, stamp);
    right.after_step(simulator, stamp);
  }

  JointStatePublisher joints;
  AssemblyInterface assembly;
  HeadInterface head;
  Arm left;
  Arm right;
  TuckService tuck;
};

RobotInterface::RobotInterface(const ros::NodeHandle& handle, ros_simulate::SimHost& host,
                               const RobotInterfaceParams& params)
    : parts_(std::make_unique<Parts>(handle, host, params)) {
  host.after_step([parts = parts_.get()](const simulate::Simulator& simulator, const ros::Time& stamp) {
    parts->after_step(simulator, stamp);
  });
}

RobotInterface::~RobotInterface() = default;

}  // namespace extperfc::ros_robot
