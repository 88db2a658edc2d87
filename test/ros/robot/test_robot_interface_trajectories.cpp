// The action follow_joint_trajectory, as a client sees it.
#include <actionlib/client/simple_action_client.h>
#include <baxter_core_msgs/JointCommand.h>
#include <control_msgs/FollowJointTrajectoryAction.h>

#include "ros/robot/names.hpp"
#include "test/ros/robot/robot_test.hpp"

namespace extperfc::ros_test {
namespace {

using control_msgs::FollowJointTrajectoryAction;
using control_msgs::FollowJointTrajectoryFeedbackConstPtr;
using control_msgs::FollowJointTrajectoryGoal;
using control_msgs::FollowJointTrajectoryResult;
using Client = actionlib::SimpleActionClient<FollowJointTrajectoryAction>;

constexpr int kE1 = 3;
constexpr int kW2 = 6;

class TrajectoriesTest : public RobotTest {
 protected:
  explicit TrajectoriesTest(bool dynamic = false) : RobotTest(dynamic) {}

  void SetUp() override {
    ASSERT_TRUE(host_.advance_until([&] { return left_.isServerConnected() && right_.isServerConnected(); }));
  }

  /// The arm with its last joint turned by `by` within that time, from rest to rest.
  FollowJointTrajectoryGoal wrist_goal(Side side, double by, double duration_s) {
    FollowJointTrajectoryGoal goal;
    trajectory_msgs::JointTrajectoryPoint point;
    const auto from = positions(side);
    for (int i = 0; i < simulate::kArmJoints; ++i)
      goal.trajectory.joint_names.push_back(ros_robot::joint_name(side, i));
    point.positions.assign(from.begin(), from.end());
    point.positions[kW2] += by;
    point.velocities.assign(simulate::kArmJoints, 0.0);
    point.time_from_start = ros::Duration(duration_s);
    goal.trajectory.points.push_back(point);
    return goal;
  }

  /// Sends it and waits until the simulation has it.
  void send_goal(Client& client, const FollowJointTrajectoryGoal& goal) {
    const auto before = host_.posted();
    client.sendGoal(goal, {}, {}, [this](const FollowJointTrajectoryFeedbackConstPtr& feedback) {
      const std::lock_guard lock(mutex_);
      feedback_.push_back(feedback);
    });
    ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
    host_.advance(0.01);
  }

  std::string wait_for_end(Client& client) {
    EXPECT_TRUE(host_.advance_until([&] { return client.getState().isDone(); }))
        << client.getState().toString();
    return client.getState().toString();
  }

  void expect_rejected(const FollowJointTrajectoryGoal& goal, int code, const std::string& why) {
    send_goal(left_, goal);
    EXPECT_EQ(wait_for_end(left_), "REJECTED");
    ASSERT_TRUE(left_.getResult());
    EXPECT_EQ(left_.getResult()->error_code, code) << left_.getResult()->error_string;
    EXPECT_NE(left_.getResult()->error_string.find(why), std::string::npos)
        << left_.getResult()->error_string;
    EXPECT_NE(left_.getState().getText().find(why), std::string::npos);
  }

  [[nodiscard]] std::vector<FollowJointTrajectoryFeedbackConstPtr> feedback() {
    const std::lock_guard lock(mutex_);
    return feedback_;
  }

  std::mutex mutex_;
  std::vector<FollowJointTrajectoryFeedbackConstPtr> feedback_;
  Client left_{"robot/limb/left/follow_joint_trajectory", true};
  Client right_{"robot/limb/right/follow_joint_trajectory", true};
};

TEST_F(TrajectoriesTest, ReachesTheGoal) {
  const auto goal = wrist_goal(Side::kLeft, 0.5, 1.0);
  const double begin_s = host_.stamp().toSec();
  send_goal(left_, goal);
  host_.advance(0.49);
  EXPECT_NEAR(position(Side::kLeft, kW2), goal.trajectory.points[0].positions[kW2] - 0.25, 0.02);
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED");
  EXPECT_GE(host_.stamp().toSec() - begin_s, 1.0);
  EXPECT_EQ(left_.getResult()->error_code, FollowJointTrajectoryResult::SUCCESSFUL);
  EXPECT_NEAR(position(Side::kLeft, kW2), goal.trajectory.points[0].positions[kW2], 1e-3);
  EXPECT_NEAR(velocity(Side::kLeft, kW2), 0, 1e-3);
}

TEST_F(TrajectoriesTest, FollowsWithinAFewMilliradians) {
  send_goal(left_, wrist_goal(Side::kLeft, 1.0, 1.0));
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED");
  ASSERT_TRUE(wait_for([&] { return feedback().size() >= 99; })) << feedback().size();
  for (const auto& message : feedback()) {
    ASSERT_EQ(message->joint_names.size(), 7U);
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_LT(std::abs(message->error.positions[i]), 0.005) << i;
      EXPECT_NEAR(message->error.positions[i], message->desired.positions[i] - message->actual.positions[i],
                  1e-12);
    }
  }
  const auto all = feedback();
  EXPECT_NEAR((all[20]->header.stamp - all[10]->header.stamp).toSec(), 0.1, 0.005) << "100 Hz";
  EXPECT_NEAR(all[50]->desired.velocities[kW2], 1.5, 0.05);
}

TEST_F(TrajectoriesTest, BothArmsMoveAtOnce) {
  send_goal(left_, wrist_goal(Side::kLeft, 0.3, 0.5));
  send_goal(right_, wrist_goal(Side::kRight, -0.3, 0.5));
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED");
  EXPECT_EQ(wait_for_end(right_), "SUCCEEDED");
}

TEST_F(TrajectoriesTest, WrongGoalsAreRejectedWithTheirCode) {
  auto goal = wrist_goal(Side::kLeft, 0.1, 0.5);
  goal.trajectory.joint_names.pop_back();
  goal.trajectory.points[0].positions.pop_back();
  expect_rejected(goal, FollowJointTrajectoryResult::INVALID_JOINTS, "left_w2 is missing");
  expect_rejected(wrist_goal(Side::kRight, 0.1, 0.5), FollowJointTrajectoryResult::INVALID_JOINTS, "left_s0");
  goal = wrist_goal(Side::kLeft, 0.1, 0.5);
  goal.trajectory.points.push_back(goal.trajectory.points[0]);
  expect_rejected(goal, FollowJointTrajectoryResult::INVALID_GOAL, "is not after");
  goal = wrist_goal(Side::kLeft, std::nan(""), 0.5);
  expect_rejected(goal, FollowJointTrajectoryResult::INVALID_GOAL, "not finite");
  goal = wrist_goal(Side::kLeft, 10, 0.5);
  expect_rejected(goal, FollowJointTrajectoryResult::INVALID_GOAL, "left_w2 at");
  goal = wrist_goal(Side::kLeft, 0.1, 0.5);
  goal.trajectory.header.stamp = ros::Time(0.3);
  expect_rejected(goal, FollowJointTrajectoryResult::OLD_HEADER_TIMESTAMP, "ago");
}

TEST_F(TrajectoriesTest, AStuckJointAborts) {
  ASSERT_TRUE(simulator_.set_fault({simulate::FaultKind::kJointStuck, "left_w2", 1, 0}));
  send_goal(left_, wrist_goal(Side::kLeft, 1, 1));
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_EQ(left_.getResult()->error_code, FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED);
  EXPECT_EQ(left_.getResult()->error_string.rfind("left_w2 is 0.2", 0), 0U)
      << left_.getResult()->error_string;
}

TEST_F(TrajectoriesTest, AStuckJointNearTheGoalMissesIt) {
  ASSERT_TRUE(simulator_.set_fault({simulate::FaultKind::kJointStuck, "left_w2", 1, 0}));
  send_goal(left_, wrist_goal(Side::kLeft, 0.1, 0.5));
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_EQ(left_.getResult()->error_code, FollowJointTrajectoryResult::GOAL_TOLERANCE_VIOLATED);
}

TEST_F(TrajectoriesTest, TolerancesOfTheGoalCount) {
  ASSERT_TRUE(simulator_.set_fault({simulate::FaultKind::kJointStuck, "left_w2", 1, 0}));
  auto goal = wrist_goal(Side::kLeft, 0.3, 0.5);
  control_msgs::JointTolerance tolerance;
  tolerance.name = "left_w2";
  tolerance.position = -1;
  goal.path_tolerance.push_back(tolerance);
  tolerance.position = 0.35;
  goal.goal_tolerance.push_back(tolerance);
  send_goal(left_, goal);
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED") << left_.getResult()->error_string;
}

TEST_F(TrajectoriesTest, AFarFirstPointViolatesThePath) {
  const auto before = positions(Side::kLeft);
  send_goal(left_, wrist_goal(Side::kLeft, 1, 0));
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_EQ(left_.getResult()->error_code, FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED);
  EXPECT_EQ(positions(Side::kLeft), before) << "nothing moved";
}

TEST_F(TrajectoriesTest, AStampInTheFutureIsWaitedFor) {
  auto goal = wrist_goal(Side::kLeft, 0.2, 0.5);
  goal.trajectory.header.stamp = host_.stamp() + ros::Duration(1.0);
  const auto before = positions(Side::kLeft);
  send_goal(left_, goal);
  host_.advance(0.95);
  EXPECT_EQ(positions(Side::kLeft), before);
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED");
  EXPECT_GE(host_.stamp(), goal.trajectory.header.stamp + ros::Duration(0.5));
}

TEST_F(TrajectoriesTest, ACancelledGoalSlowsDownAndHolds) {
  send_goal(left_, wrist_goal(Side::kLeft, 2, 2));
  host_.advance(1);
  const double speed = velocity(Side::kLeft, kW2);
  ASSERT_GT(speed, 1.4);
  const auto before = host_.posted();
  left_.cancelGoal();
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
  host_.advance(0.1);
  EXPECT_GT(velocity(Side::kLeft, kW2), 0.5) << "not at once";
  EXPECT_LT(velocity(Side::kLeft, kW2), speed - 0.3);
  EXPECT_EQ(left_.getState().toString(), "ACTIVE") << "preempted when it is at rest";
  EXPECT_EQ(wait_for_end(left_), "PREEMPTED");
  EXPECT_NE(left_.getResult()->error_code, FollowJointTrajectoryResult::SUCCESSFUL);
  const auto rest = positions(Side::kLeft);
  host_.advance(1);
  EXPECT_EQ(positions(Side::kLeft), rest);
}

TEST_F(TrajectoriesTest, AGoalCancelledBeforeItBeginsIsRecalled) {
  const auto before = host_.posted();
  const auto from = positions(Side::kLeft);
  left_.sendGoal(wrist_goal(Side::kLeft, 1, 1));
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
  left_.cancelGoal();
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before + 1; }));
  const auto state = wait_for_end(left_);
  EXPECT_TRUE(state == "RECALLED" || state == "PREEMPTED") << state;
  host_.advance(0.5);
  EXPECT_EQ(positions(Side::kLeft), from);
}

TEST_F(TrajectoriesTest, ANewGoalPreemptsTheOldOneWithoutAJerk) {
  Client other("robot/limb/left/follow_joint_trajectory", true);
  ASSERT_TRUE(host_.advance_until([&] { return other.isServerConnected(); }));
  auto second = wrist_goal(Side::kLeft, 0.3, 1.5);
  send_goal(left_, wrist_goal(Side::kLeft, 1, 1));
  host_.advance(0.5);
  const double speed = velocity(Side::kLeft, kW2);
  send_goal(other, second);
  EXPECT_NEAR(velocity(Side::kLeft, kW2), speed, 0.15);
  EXPECT_EQ(wait_for_end(left_), "PREEMPTED");
  EXPECT_NE(left_.getResult()->error_string.find("newer"), std::string::npos);
  EXPECT_EQ(wait_for_end(other), "SUCCEEDED");
  EXPECT_NEAR(position(Side::kLeft, kW2), second.trajectory.points[0].positions[kW2], 1e-3);
}

TEST_F(TrajectoriesTest, ARejectedGoalDoesNotPreempt) {
  Client other("robot/limb/left/follow_joint_trajectory", true);
  ASSERT_TRUE(host_.advance_until([&] { return other.isServerConnected(); }));
  send_goal(left_, wrist_goal(Side::kLeft, 0.5, 1));
  send_goal(other, FollowJointTrajectoryGoal());
  EXPECT_EQ(wait_for_end(other), "REJECTED");
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED");
}

TEST_F(TrajectoriesTest, AJointCommandTakesTheArm) {
  auto commands = handle_.advertise<baxter_core_msgs::JointCommand>("robot/limb/left/joint_command", 1);
  send_goal(left_, wrist_goal(Side::kLeft, 1, 1));
  host_.advance(0.3);
  baxter_core_msgs::JointCommand command;
  command.mode = baxter_core_msgs::JointCommand::RAW_POSITION_MODE;
  command.names = {"left_e1"};
  const double elbow = position(Side::kLeft, kE1);
  command.command = {elbow + 0.05};
  send(commands, command);
  host_.advance(0.1);
  EXPECT_NEAR(position(Side::kLeft, kE1), elbow + 0.05, 1e-3) << "not lost between two set points";
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_NE(left_.getResult()->error_string.find("robot/limb/left/joint_command"), std::string::npos);
}

TEST_F(TrajectoriesTest, ADisabledRobotTakesNoGoal) {
  simulator_.enable(false);
  expect_rejected(wrist_goal(Side::kLeft, 0.1, 0.5), FollowJointTrajectoryResult::INVALID_GOAL,
                  "the robot is disabled: publish true on robot/set_super_enable");
}

TEST_F(TrajectoriesTest, TheEmergencyStopAborts) {
  send_goal(left_, wrist_goal(Side::kLeft, 1, 1));
  host_.advance(0.5);
  simulator_.stop();
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_NE(left_.getResult()->error_code, FollowJointTrajectoryResult::SUCCESSFUL);
  EXPECT_NE(left_.getResult()->error_string.find("robot/set_super_reset"), std::string::npos)
      << left_.getResult()->error_string;
  const auto rest = positions(Side::kLeft);
  simulator_.reset_stop();
  simulator_.enable(true);
  host_.advance(1);
  EXPECT_EQ(positions(Side::kLeft), rest) << "it does not go on by itself";
}

TEST_F(TrajectoriesTest, AResetOfTheSimulationAborts) {
  send_goal(left_, wrist_goal(Side::kLeft, 1, 1));
  host_.advance(0.5);
  ASSERT_TRUE(simulator_.reset());
  EXPECT_EQ(wait_for_end(left_), "ABORTED");
  EXPECT_NE(left_.getResult()->error_string.find("clock"), std::string::npos);
}

TEST_F(TrajectoriesTest, WithoutASimulationGoalsAreRejected) {
  host_.close();
  left_.sendGoal(wrist_goal(Side::kLeft, 1, 1));
  EXPECT_TRUE(wait_for([&] { return left_.getState().isDone(); }));
  EXPECT_EQ(left_.getState().toString(), "REJECTED");
}

class DynamicTrajectoriesTest : public TrajectoriesTest {
 protected:
  DynamicTrajectoriesTest() : TrajectoriesTest(true) {}
};

TEST_F(DynamicTrajectoriesTest, MotorsFollowWithinTheTolerances) {
  auto goal = wrist_goal(Side::kLeft, 0.5, 2.0);
  goal.trajectory.points[0].positions[1] -= 0.3;  // the shoulder lifts the whole arm
  send_goal(left_, goal);
  EXPECT_EQ(wait_for_end(left_), "SUCCEEDED") << left_.getResult()->error_string;
  ASSERT_TRUE(wait_for([&] { return feedback().size() >= 199; }));
  double largest = 0;
  for (const auto& message : feedback())
    for (const double error : message->error.positions) largest = std::max(largest, std::abs(error));
  EXPECT_LT(largest, 0.02) << "[rad]";
  EXPECT_GT(largest, 0) << "motors are not exact";
  RecordProperty("largest_error_rad", std::to_string(largest));
}

}  // namespace
}  // namespace extperfc::ros_test
