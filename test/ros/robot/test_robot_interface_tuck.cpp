// The service that tucks and untucks both arms, and the program that calls it.
#include <future>

#include <actionlib/client/simple_action_client.h>
#include <baxter_core_msgs/JointCommand.h>
#include <ros/package.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/SetBool.h>

#include "ros/robot/tuck_plan.hpp"
#include "test/ros/robot/robot_test.hpp"
#include "test/ros/support/child_process.hpp"

namespace extperfc::ros_test {
namespace {

class TuckTest : public RobotTest {
 protected:
  using Answer = std_srvs::SetBool::Response;

  std::future<Answer> call(bool tuck) {
    return std::async(std::launch::async, [this, tuck] {
      std_srvs::SetBool service;
      service.request.data = tuck;
      if (!handle_.serviceClient<std_srvs::SetBool>("robot/tuck_arms").call(service))
        service.response.message = "the call failed";
      return service.response;
    });
  }
  static bool ready(std::future<Answer>& answer) {
    return answer.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  Answer wait_for_answer(std::future<Answer> answer) {
    EXPECT_TRUE(host_.advance_until([&] { return ready(answer); }));
    return answer.get();
  }
  [[nodiscard]] bool is_in(ArmValues (*pose)(Side)) {
    for (const Side side : simulate::kSides)
      for (int i = 0; i < simulate::kArmJoints; ++i)
        if (std::abs(position(side, i) - pose(side)[i]) > 0.01) return false;
    return true;
  }
};

TEST_F(TuckTest, TucksAndUntucks) {
  ASSERT_TRUE(is_in(ros_robot::untucked_pose)) << "the simulator's start";
  auto answer = wait_for_answer(call(true));
  EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_EQ(answer.message, "tucked");
  EXPECT_TRUE(is_in(ros_robot::tucked_pose));
  answer = wait_for_answer(call(true));
  EXPECT_TRUE(answer.success) << "again: " << answer.message;
  answer = wait_for_answer(call(false));
  EXPECT_TRUE(answer.success) << answer.message;
  EXPECT_EQ(answer.message, "untucked");
  EXPECT_TRUE(is_in(ros_robot::untucked_pose));
}

TEST_F(TuckTest, ADisabledRobotRefuses) {
  simulator_.enable(false);
  const auto answer = wait_for_answer(call(true));
  EXPECT_FALSE(answer.success);
  EXPECT_NE(answer.message.find("the robot is disabled: publish true on robot/set_super_enable"),
            std::string::npos)
      << answer.message;
}

TEST_F(TuckTest, ADisabledArmGivesUpOnTheWay) {
  auto answer = call(true);
  ASSERT_TRUE(host_.advance_until([&] { return !is_in(ros_robot::untucked_pose); }));
  simulator_.enable(false);
  const auto given = wait_for_answer(std::move(answer));
  EXPECT_FALSE(given.success);
  EXPECT_NE(given.message.find("arm: aborted: the robot is disabled"), std::string::npos) << given.message;
}

TEST_F(TuckTest, OneArmThatFailsStopsTheOther) {
  ASSERT_TRUE(simulator_.set_fault({simulate::FaultKind::kJointStuck, "right_e0", 1, 0}));
  const auto answer = wait_for_answer(call(true));
  EXPECT_FALSE(answer.success);
  EXPECT_EQ(answer.message.rfind("right arm: right_e0 is", 0), 0U) << answer.message;
  const auto rest = positions(Side::kLeft);
  host_.advance(1);
  EXPECT_EQ(positions(Side::kLeft), rest);
}

TEST_F(TuckTest, AJointCommandEndsIt) {
  auto commands = handle_.advertise<baxter_core_msgs::JointCommand>("robot/limb/left/joint_command", 1);
  auto answer = call(true);
  ASSERT_TRUE(host_.advance_until([&] { return !is_in(ros_robot::untucked_pose); }));
  baxter_core_msgs::JointCommand command;
  command.mode = baxter_core_msgs::JointCommand::VELOCITY_MODE;
  command.names = {"left_s0"};
  command.command = {0};
  send(commands, command);
  const auto given = wait_for_answer(std::move(answer));
  EXPECT_FALSE(given.success);
  EXPECT_NE(given.message.find("joint_command"), std::string::npos) << given.message;
}

TEST_F(TuckTest, TopicsLiveMeanwhile) {
  const Inbox<sensor_msgs::JointState> states("robot/joint_states");
  auto first = call(true);
  auto second = call(false);  // waits for the first, or the other way round
  ASSERT_TRUE(host_.advance_until([&] { return !is_in(ros_robot::untucked_pose) && states.count() > 10; }));
  EXPECT_FALSE(ready(first) && ready(second));
  EXPECT_TRUE(wait_for_answer(std::move(first)).success);
  EXPECT_TRUE(wait_for_answer(std::move(second)).success);
}

TEST_F(TuckTest, TheProgramDoesIt) {
  const auto program = ros::package::getPath("extperfc") + "/tools/tuck_arms";
  ChildProcess tuck({program, "-t"});
  EXPECT_TRUE(host_.advance_until([&] { return !tuck.running(); }));
  EXPECT_EQ(tuck.wait_for_end(), 0);
  EXPECT_TRUE(is_in(ros_robot::tucked_pose));
  simulator_.enable(false);
  ChildProcess untuck({program, "--untuck"});
  EXPECT_TRUE(host_.advance_until([&] { return !untuck.running(); }));
  EXPECT_EQ(untuck.wait_for_end(), 1);
  ChildProcess help({program, "--help"});
  EXPECT_EQ(help.wait_for_end(), 0);
  ChildProcess nothing({program});
  EXPECT_EQ(nothing.wait_for_end(), 2);
}

}  // namespace
}  // namespace extperfc::ros_test
