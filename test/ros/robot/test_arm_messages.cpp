// Messages of the robot and its arms <-> the simulator's types.
#include <limits>

#include <gtest/gtest.h>

#include "ros/robot/arm_messages.hpp"
#include "test/ros/robot/joint_command.hpp"

namespace extperfc::ros_robot {
namespace {

using baxter_core_msgs::AssemblyState;
using baxter_core_msgs::JointCommand;
using ros_test::joint_command;
using simulate::ArmMode;
using simulate::RobotState;
using simulate::Side;

TEST(ArmMessages, ACommandNamesItsJoints) {
  const auto converted = from_message(
      joint_command(JointCommand::VELOCITY_MODE, {"right_w2", "right_s0"}, {0.2, -0.1}), Side::kRight);
  ASSERT_TRUE(converted) << converted.error().message;
  EXPECT_EQ(converted->mode, ArmMode::kVelocity);
  EXPECT_EQ(converted->values[0], -0.1);
  EXPECT_EQ(converted->values[6], 0.2);
  for (const int unnamed : {1, 2, 3, 4, 5}) EXPECT_FALSE(converted->values[unnamed]) << unnamed;
}

TEST(ArmMessages, EveryModeIsKnown) {
  for (const auto& [mode, wanted] : {std::pair{1, ArmMode::kPosition}, std::pair{2, ArmMode::kVelocity},
                                     std::pair{3, ArmMode::kTorque}, std::pair{4, ArmMode::kRawPosition}}) {
    const auto converted = from_message(joint_command(mode, {"left_s0"}, {0}), Side::kLeft);
    ASSERT_TRUE(converted);
    EXPECT_EQ(converted->mode, wanted);
  }
}

TEST(ArmMessages, WrongCommandsAreRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<JointCommand, const char*>> wrong{
      {joint_command(0, {"left_s0"}, {0}), "mode 0"},
      {joint_command(5, {"left_s0"}, {0}), "mode 5"},
      {joint_command(1, {}, {}), "no joint"},
      {joint_command(1, {"left_s0"}, {}), "1 names and 0 values"},
      {joint_command(1, {"left_s0"}, {1, 2}), "1 names and 2 values"},
      {joint_command(1, {"right_s0"}, {0}),
       "'right_s0' is not a joint of this arm; its joints are left_s0 to left_w2"},
      {joint_command(1, {"left_s0", "left_s0"}, {0, 0}), "left_s0 is given twice"},
      {joint_command(1, {"left_s0", "left_w0"}, {0, nan}), "left_w0 has a value that is not finite"}};
  for (const auto& [message, why] : wrong) {
    const auto converted = from_message(message, Side::kLeft);
    ASSERT_FALSE(converted) << why;
    EXPECT_NE(converted.error().message.find(why), std::string::npos) << converted.error().message;
  }
}

TEST(ArmMessages, StopsHaveTheirSource) {
  RobotState state;
  auto message = to_message(state);
  EXPECT_EQ(message.estop_source, AssemblyState::ESTOP_SOURCE_NONE);
  EXPECT_EQ(message.estop_button, AssemblyState::ESTOP_BUTTON_UNPRESSED);
  state.stopped = true;
  state.source = RobotState::Stop::kButton;
  message = to_message(state);
  EXPECT_TRUE(message.stopped);
  EXPECT_EQ(message.estop_source, AssemblyState::ESTOP_SOURCE_USER);
  EXPECT_EQ(message.estop_button, AssemblyState::ESTOP_BUTTON_RELEASED);
  state.source = RobotState::Stop::kFault;
  EXPECT_EQ(to_message(state).estop_source, AssemblyState::ESTOP_SOURCE_FAULT);
  state.source = RobotState::Stop::kUnknown;
  EXPECT_EQ(to_message(state).estop_source, AssemblyState::ESTOP_SOURCE_UNKNOWN);
  EXPECT_EQ(to_message(state).estop_button, AssemblyState::ESTOP_BUTTON_UNKNOWN);
}

TEST(ArmMessages, TheEndPointKeepsPoseTwistAndWrench) {
  simulate::ArmState state;
  state.base_T_endpoint.translation() = Eigen::Vector3d(1, 2, 3);
  state.base_T_endpoint.linear() =
      Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  state.twist << 1, 2, 3, 4, 5, 6;
  state.wrench << 7, 8, 9, 10, 11, 12;
  const auto message = endpoint_message(state, ros::Time(5, 6));
  EXPECT_EQ(message.header.stamp, ros::Time(5, 6));
  EXPECT_EQ(message.pose.position.y, 2);
  const auto& q = message.pose.orientation;
  EXPECT_TRUE(Eigen::Quaterniond(q.w, q.x, q.y, q.z)
                  .toRotationMatrix()
                  .isApprox(state.base_T_endpoint.rotation(), 1e-12));
  EXPECT_EQ(message.twist.linear.z, 3);
  EXPECT_EQ(message.twist.angular.x, 4);
  EXPECT_EQ(message.wrench.force.x, 7);
  EXPECT_EQ(message.wrench.torque.z, 12);
}

TEST(ArmMessages, TorquesComeFromTheirFields) {
  simulate::ArmState state;
  state.command[1] = 1;
  state.position[2] = 2;
  state.velocity[3] = 3;
  state.effort[4] = 4;
  state.gravity[5] = 5;
  const auto message = torques_message(state, Side::kLeft, ros::Time(1));
  EXPECT_EQ(message.name[5], "left_w1");
  EXPECT_EQ(message.commanded_position[1], 1);
  EXPECT_EQ(message.actual_position[2], 2);
  EXPECT_EQ(message.actual_velocity[3], 3);
  EXPECT_EQ(message.actual_effort[4], 4);
  EXPECT_EQ(message.gravity_model_effort[5], 5);
  EXPECT_EQ(message.gravity_only[5], 5);
}

}  // namespace
}  // namespace extperfc::ros_robot
