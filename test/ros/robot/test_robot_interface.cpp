// The robot as a whole: joint states, on and off, e-stop, head, parameters.
#include <limits>
#include <set>

#include <baxter_core_msgs/AssemblyState.h>
#include <baxter_core_msgs/HeadPanCommand.h>
#include <baxter_core_msgs/HeadState.h>
#include <ros/package.h>
#include <ros/param.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Empty.h>
#include <std_msgs/UInt16.h>
#include <yaml-cpp/yaml.h>

#include "test/ros/robot/robot_test.hpp"

namespace extperfc::ros_test {
namespace {

using baxter_core_msgs::AssemblyState;
using baxter_core_msgs::HeadPanCommand;

std_msgs::Bool make_bool(bool value) {
  std_msgs::Bool message;
  message.data = value;
  return message;
}

TEST_F(RobotTest, JointStatesComeAHundredTimesPerSecondWithEveryJoint) {
  const Inbox<sensor_msgs::JointState> states("robot/joint_states");
  ASSERT_TRUE(wait_for([&] { return states.connected(); }));
  host_.advance(1);
  ASSERT_TRUE(states.wait_for_count(100));
  EXPECT_TRUE(never([&] { return states.count() > 100; }, 0.2));
  const auto& message = *states.all().back();
  EXPECT_NEAR(message.header.stamp.toSec(), host_.stamp().toSec(), 0.01);
  ASSERT_EQ(message.position.size(), message.name.size());
  ASSERT_EQ(message.velocity.size(), message.name.size());
  ASSERT_EQ(message.effort.size(), message.name.size());
  const std::set<std::string> names(message.name.begin(), message.name.end());
  for (const char* joint : {"left_s0", "right_w2", "head_pan", "wheel_front_left_joint",
                            "wheel_rear_right_joint", "l_gripper_l_finger_joint", "r_gripper_r_finger_joint"})
    EXPECT_TRUE(names.count(joint)) << joint;
  const auto elbow = std::find(message.name.begin(), message.name.end(), "left_e1") - message.name.begin();
  EXPECT_NEAR(message.position[static_cast<std::size_t>(elbow)], position(Side::kLeft, 3), 1e-9);
}

TEST_F(RobotTest, TheJointStateRateCanBeChanged) {
  const Inbox<sensor_msgs::JointState> states("robot/joint_states");
  auto rate = handle_.advertise<std_msgs::UInt16>("robot/joint_state_publish_rate", 1);
  ASSERT_TRUE(wait_for([&] { return states.connected(); }));
  std_msgs::UInt16 hz;
  hz.data = 20;
  send(rate, hz);
  host_.advance(0.1);
  const auto before = host_.stamp();
  host_.advance(1);
  const auto count = [&] {
    std::size_t later = 0;
    for (const auto& state : states.all())
      if (state->header.stamp > before) ++later;
    return later;
  };
  EXPECT_TRUE(wait_for([&] { return count() == 20; })) << count();
  EXPECT_TRUE(never([&] { return count() > 20; }, 0.2)) << count();
}

TEST_F(RobotTest, AWrongJointStateRateIsRefusedAloud) {
  auto rate = handle_.advertise<std_msgs::UInt16>("robot/joint_state_publish_rate", 1);
  for (const std::uint16_t wrong : std::vector<std::uint16_t>{0, 1001}) {
    std_msgs::UInt16 hz;
    hz.data = wrong;
    log_.forget();
    EXPECT_TRUE(wait_for([&] {  // until the log is connected
      rate.publish(hz);
      return log_.count("Hz is outside [1, 1000]") > 0;
    })) << log_.text();
  }
  const Inbox<sensor_msgs::JointState> states("robot/joint_states");
  ASSERT_TRUE(wait_for([&] { return states.connected(); }));
  host_.advance(1);
  EXPECT_TRUE(states.wait_for_count(100)) << "the rate stays";
}

TEST_F(RobotTest, IsEnabledAndDisabled) {
  auto enable = handle_.advertise<std_msgs::Bool>("robot/set_super_enable", 1);
  Inbox<AssemblyState> states("robot/state");
  EXPECT_TRUE(next(states)->enabled);
  send(enable, make_bool(false));
  host_.advance(0.02);
  EXPECT_FALSE(next(states)->enabled);
  send(enable, make_bool(true));
  host_.advance(0.02);
  const auto state = next(states);
  EXPECT_TRUE(state->enabled);
  EXPECT_TRUE(state->ready);
  EXPECT_FALSE(state->stopped);
  EXPECT_FALSE(state->error);
}

TEST_F(RobotTest, TheEmergencyStopHoldsUntilItIsReset) {
  auto enable = handle_.advertise<std_msgs::Bool>("robot/set_super_enable", 1);
  auto stop = handle_.advertise<std_msgs::Empty>("robot/set_super_stop", 1);
  auto reset = handle_.advertise<std_msgs::Empty>("robot/set_super_reset", 1);
  Inbox<AssemblyState> states("robot/state");
  send(stop, std_msgs::Empty());
  host_.advance(0.02);
  auto state = next(states);
  EXPECT_TRUE(state->stopped);
  EXPECT_FALSE(state->enabled);
  EXPECT_EQ(state->estop_source, AssemblyState::ESTOP_SOURCE_USER);
  EXPECT_NE(state->estop_button, AssemblyState::ESTOP_BUTTON_PRESSED) << "a client could not reset it";
  send(enable, make_bool(true));
  host_.advance(0.02);
  EXPECT_FALSE(next(states)->enabled) << "stopped";
  send(reset, std_msgs::Empty());
  host_.advance(0.02);
  state = next(states);
  EXPECT_FALSE(state->stopped);
  EXPECT_FALSE(state->enabled) << "a reset does not enable";
  EXPECT_EQ(state->estop_source, AssemblyState::ESTOP_SOURCE_NONE);
  EXPECT_EQ(state->estop_button, AssemblyState::ESTOP_BUTTON_UNPRESSED);
  send(enable, make_bool(true));
  host_.advance(0.02);
  EXPECT_TRUE(next(states)->enabled);
}

TEST_F(RobotTest, AResetWithoutAStopChangesNothing) {
  auto reset = handle_.advertise<std_msgs::Empty>("robot/set_super_reset", 1);
  Inbox<AssemblyState> states("robot/state");
  send(reset, std_msgs::Empty());
  host_.advance(0.02);
  EXPECT_TRUE(next(states)->enabled);
}

TEST_F(RobotTest, StatesComeAHundredTimesPerSecond) {
  const Inbox<AssemblyState> states("robot/state");
  const Inbox<baxter_core_msgs::HeadState> heads("robot/head/head_state");
  ASSERT_TRUE(wait_for([&] { return states.connected() && heads.connected(); }));
  host_.advance(1);
  EXPECT_TRUE(states.wait_for_count(100));
  EXPECT_TRUE(heads.wait_for_count(100));
  EXPECT_TRUE(never([&] { return states.count() > 100 || heads.count() > 100; }, 0.2));
}

HeadPanCommand pan_to(float target, float ratio = 1.0F) {
  HeadPanCommand command;
  command.target = target;
  command.speed_ratio = ratio;
  command.enable_pan_request = HeadPanCommand::REQUEST_PAN_VOID;
  return command;
}

TEST_F(RobotTest, TheHeadTurns) {
  auto pan = handle_.advertise<HeadPanCommand>("robot/head/command_head_pan", 1);
  Inbox<baxter_core_msgs::HeadState> states("robot/head/head_state");
  send(pan, pan_to(0.5F));
  host_.advance(0.1);
  const auto turning = next(states);
  EXPECT_TRUE(turning->isTurning);
  EXPECT_TRUE(turning->isPanEnabled);
  host_.advance(3);
  const auto there = next(states);
  EXPECT_NEAR(there->pan, 0.5, 0.02);
  EXPECT_FALSE(there->isTurning);
}

TEST_F(RobotTest, AHeadWithoutItsMotorStays) {
  auto pan = handle_.advertise<HeadPanCommand>("robot/head/command_head_pan", 1);
  Inbox<baxter_core_msgs::HeadState> states("robot/head/head_state");
  auto command = pan_to(0.5F);
  command.enable_pan_request = HeadPanCommand::REQUEST_PAN_DISABLE;
  send(pan, command);
  send(pan, pan_to(0.5F));
  host_.advance(1);
  const auto off = next(states);
  EXPECT_FALSE(off->isPanEnabled);
  EXPECT_NEAR(off->pan, 0, 0.01);
  command.enable_pan_request = HeadPanCommand::REQUEST_PAN_ENABLE;
  send(pan, command);
  host_.advance(3);
  EXPECT_NEAR(next(states)->pan, 0.5, 0.02);
}

TEST_F(RobotTest, AWrongHeadCommandIsIgnored) {
  auto pan = handle_.advertise<HeadPanCommand>("robot/head/command_head_pan", 10);
  send_in_vain(pan, pan_to(std::numeric_limits<float>::quiet_NaN()));
  send_in_vain(pan, pan_to(0.5F, 1.5F));
  const auto before = host_.posted();
  send(pan, pan_to(-0.5F));
  EXPECT_EQ(host_.posted(), before + 1) << "only the good one, which came last";
  host_.advance(3);
  EXPECT_NEAR(simulator_.head_state().pan, -0.5, 0.02);
}

TEST_F(RobotTest, TheHeadNodsOnCommand) {
  auto nod = handle_.advertise<std_msgs::Bool>("robot/head/command_head_nod", 10);
  Inbox<baxter_core_msgs::HeadState> states("robot/head/head_state");
  send_in_vain(nod, make_bool(false));
  send(nod, make_bool(true));
  host_.advance(0.1);
  EXPECT_TRUE(next(states)->isNodding);
  EXPECT_TRUE(host_.advance_until([&] { return !simulator_.head_state().nodding; }));
}

TEST_F(RobotTest, CommandsWithoutASimulationAreRefusedAloud) {
  auto enable = handle_.advertise<std_msgs::Bool>("robot/set_super_enable", 1);
  host_.close();
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    enable.publish(make_bool(false));
    return log_.count("robot/set_super_enable: the simulation accepts no commands now") > 0;
  })) << log_.text();
  EXPECT_TRUE(simulator_.robot_state().enabled);
}

TEST(RobotInterfaceParams, AreReadFromTheNamespaceRobot) {
  const ros::NodeHandle handle("/some_simulator");
  ros::param::set("/some_simulator/robot/path_tolerance_rad", 0.5);
  const auto params = ros_params::load_robot_interface_params(handle);
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->trajectory.path_tolerance_rad, 0.5);
  ros::param::set("/some_simulator/robot/path_tolerance", 0.5);
  ros::param::set("/some_simulator/robot/tuck_speed_rad_s", 10.0);
  const auto wrong = ros_params::load_robot_interface_params(handle);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("robot/path_tolerance is not a parameter"), std::string::npos)
      << wrong.error().message;
  EXPECT_NE(wrong.error().message.find("robot/tuck_speed_rad_s = 10 is out of its range"), std::string::npos)
      << wrong.error().message;
  ros::param::del("/some_simulator");
}

TEST(RobotInterfaceParams, OfTheShippedConfigurationAreTheDefaults) {
  const auto file = YAML::LoadFile(ros::package::getPath("extperfc") + "/config/robot_interface.yaml");
  for (const auto& entry : file)
    ros::param::set("/some_simulator/robot/" + entry.first.as<std::string>(), entry.second.as<double>());
  const auto shipped = ros_params::load_robot_interface_params(ros::NodeHandle("/some_simulator"));
  ASSERT_TRUE(shipped) << shipped.error().message;
  const ros_params::RobotInterfaceParams defaults;
  EXPECT_EQ(file.size(), 13U) << "every parameter is in the file, and compared here";
  EXPECT_EQ(shipped->joint_state_rate_hz, defaults.joint_state_rate_hz);
  EXPECT_EQ(shipped->state_rate_hz, defaults.state_rate_hz);
  EXPECT_EQ(shipped->feedback_rate_hz, defaults.feedback_rate_hz);
  EXPECT_EQ(shipped->trajectory.path_tolerance_rad, defaults.trajectory.path_tolerance_rad);
  EXPECT_EQ(shipped->trajectory.goal_tolerance_rad, defaults.trajectory.goal_tolerance_rad);
  EXPECT_EQ(shipped->trajectory.goal_time_s, defaults.trajectory.goal_time_s);
  EXPECT_EQ(shipped->trajectory.stopped_velocity_rad_s, defaults.trajectory.stopped_velocity_rad_s);
  EXPECT_EQ(shipped->trajectory.stop_deceleration_rad_s2, defaults.trajectory.stop_deceleration_rad_s2);
  EXPECT_EQ(shipped->trajectory.longest_wait_for_start_s, defaults.trajectory.longest_wait_for_start_s);
  EXPECT_EQ(shipped->gripper_tolerance_percent, defaults.gripper_tolerance_percent);
  EXPECT_EQ(shipped->gripper_timeout_s, defaults.gripper_timeout_s);
  EXPECT_EQ(shipped->tuck_speed_rad_s, defaults.tuck_speed_rad_s);
  EXPECT_EQ(shipped->tuck_accel_rad_s2, defaults.tuck_accel_rad_s2);
  ros::param::del("/some_simulator");
}

}  // namespace
}  // namespace extperfc::ros_test
