// Commands of Baxter's electric gripper.
#include <gtest/gtest.h>

#include "ros/robot/gripper_messages.hpp"

namespace extperfc::ros_robot {
namespace {

using baxter_core_msgs::EndEffectorCommand;
using baxter_core_msgs::EndEffectorState;
using Kind = simulate::GripperCommand::Kind;

EndEffectorCommand command(const std::string& name, const std::string& args = "") {
  EndEffectorCommand message;
  message.id = kGripperId;
  message.command = name;
  message.args = args;
  return message;
}

TEST(GripperMessages, EveryCommandIsKnown) {
  const std::vector<std::pair<std::string, Kind>> all{{"no_op", Kind::kNoop},
                                                      {"set", Kind::kConfigure},
                                                      {"configure", Kind::kConfigure},
                                                      {"reboot", Kind::kReboot},
                                                      {"reset", Kind::kReset},
                                                      {"calibrate", Kind::kCalibrate},
                                                      {"clear_calibration", Kind::kClearCalibration},
                                                      {"prepare_to_grip", Kind::kGoTo},
                                                      {"grip", Kind::kGoTo},
                                                      {"release", Kind::kGoTo},
                                                      {"stop", Kind::kStop}};
  for (const auto& [name, kind] : all) {
    const auto converted = from_message(command(name));
    ASSERT_TRUE(converted) << name;
    EXPECT_EQ(converted->kind, kind) << name;
  }
}

TEST(GripperMessages, PositionsAreThoseOfTheCommand) {
  EXPECT_EQ(from_message(command("go", R"({"position": 42.5})"))->position_percent, 42.5);
  EXPECT_EQ(from_message(command("go", R"({"position": 0})"))->position_percent, 0);
  EXPECT_EQ(from_message(command("grip"))->position_percent, 0);
  EXPECT_EQ(from_message(command("release"))->position_percent, 100);
  EXPECT_EQ(from_message(command("prepare_to_grip"))->position_percent, 100);
}

TEST(GripperMessages, ParametersAreTaken) {
  const auto converted = from_message(command(
      "configure", R"({"velocity": 50.0, "moving_force": 40, "holding_force": 30.5, "dead_zone": 5})"));
  ASSERT_TRUE(converted) << converted.error().message;
  EXPECT_EQ(converted->velocity_percent, 50);
  EXPECT_EQ(converted->moving_force_percent, 40);
  EXPECT_EQ(converted->holding_force_percent, 30.5);
  EXPECT_EQ(converted->dead_zone_percent, 5);
  const auto some = from_message(command("set", R"({"velocity": 10.0})"));
  ASSERT_TRUE(some);
  EXPECT_EQ(some->velocity_percent, 10);
  EXPECT_FALSE(some->moving_force_percent) << "unchanged";
}

TEST(GripperMessages, AnEmptyObjectIsNoArguments) {
  EXPECT_TRUE(from_message(command("grip", "{}")));
}

TEST(GripperMessages, WrongCommandsAreRefusedByName) {
  const std::vector<std::pair<EndEffectorCommand, const char*>> wrong{
      {command("dance"), "'dance' is no command"},
      {command(""), "'' is no command"},
      {command("go"), "'go' needs args with a position"},
      {command("go", R"({"velocity": 5})"), "'go' needs args with a position"},
      {command("go", R"({"position": 101})"), "position outside [0, 100]"},
      {command("go", R"({"position": -1})"), "position outside [0, 100]"},
      {command("go", R"({"position": "far"})"), "no number for 'position'"},
      {command("go", R"({"position": {"x": 1}})"), "no number for 'position'"},
      {command("go", R"({"position": NaN})"), "are not a JSON object"},
      {command("go", R"({"position": 5)"), "are not a JSON object"},
      {command("go", R"({'position': 5})"), "are not a JSON object"},
      {command("go", "50"), "are not a JSON object"},
      {command("go", R"({"position": 5, "colour": 5})"), "'colour' is no argument"}};
  for (const auto& [message, why] : wrong) {
    const auto converted = from_message(message);
    ASSERT_FALSE(converted) << message.args;
    EXPECT_NE(converted.error().message.find(why), std::string::npos) << converted.error().message;
  }
}

TEST(GripperMessages, AnotherGrippersCommandIsRefused) {
  auto message = command("grip");
  message.id = 1;
  const auto converted = from_message(message);
  ASSERT_FALSE(converted);
  EXPECT_NE(converted.error().message.find("this one is 65664"), std::string::npos);
}

TEST(GripperMessages, StateHasEveryFlag) {
  simulate::GripperState state;
  state.calibrated = true;
  state.gripping = true;
  state.position_percent = 12;
  state.force_percent = 34;
  const auto message = to_message(state, true, ros::Time(2));
  EXPECT_EQ(message.enabled, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(message.calibrated, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(message.ready, EndEffectorState::STATE_FALSE);
  EXPECT_EQ(message.gripping, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(message.missed, EndEffectorState::STATE_FALSE);
  EXPECT_EQ(message.position, 12);
  EXPECT_EQ(message.force, 34);
  EXPECT_EQ(message.timestamp, ros::Time(2));
}

}  // namespace
}  // namespace extperfc::ros_robot
