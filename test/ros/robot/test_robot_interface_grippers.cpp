// The grippers' topics and their action.
#include <actionlib/client/simple_action_client.h>
#include <baxter_core_msgs/EndEffectorCommand.h>
#include <baxter_core_msgs/EndEffectorProperties.h>
#include <baxter_core_msgs/EndEffectorState.h>
#include <control_msgs/GripperCommandAction.h>

#include "test/ros/robot/robot_test.hpp"

namespace extperfc::ros_test {
namespace {

using baxter_core_msgs::EndEffectorCommand;
using baxter_core_msgs::EndEffectorProperties;
using baxter_core_msgs::EndEffectorState;
using control_msgs::GripperCommandGoal;

class GrippersTest : public RobotTest {
 protected:
  EndEffectorCommand command(const std::string& name, const std::string& args = "") {
    EndEffectorCommand message;
    message.id = id_;
    message.command = name;
    message.args = args;
    message.sender = "a test";
    message.sequence = ++sequence_;
    return message;
  }

  [[nodiscard]] double opening(Side side = Side::kLeft) {
    return simulator_.gripper_state(side).position_percent;
  }

  using Kind = simulate::GripperCommand::Kind;
  static simulate::GripperCommand make(Kind kind) {
    simulate::GripperCommand command;
    command.kind = kind;
    return command;
  }

  /// As a user does after switching on.
  void calibrate() {
    for (const Side side : simulate::kSides)
      ASSERT_TRUE(simulator_.command_gripper(side, make(Kind::kCalibrate)));
    ASSERT_TRUE(host_.advance_until([&] {
      return simulator_.gripper_state(Side::kLeft).calibrated &&
             simulator_.gripper_state(Side::kRight).calibrated;
    }));
  }
  void put_cube_between_the_fingers() {
    const auto link = simulator_.robot().link("left_gripper");
    ASSERT_TRUE(link);
    ASSERT_TRUE(simulator_.move_body("cube", simulator_.snapshot().world_T_link[*link]));
  }

  std::uint32_t id_{65664};
  std::uint32_t sequence_{0};
  ros::Publisher left_ = handle_.advertise<EndEffectorCommand>("robot/end_effector/left_gripper/command", 10);
};

TEST_F(GrippersTest, PropertiesAreLatched) {
  const Inbox<EndEffectorProperties> inbox("robot/end_effector/right_gripper/properties");
  ASSERT_TRUE(inbox.wait_for_count(1));
  const auto properties = inbox.all().front();
  EXPECT_EQ(properties->ui_type, EndEffectorProperties::ELECTRIC_GRIPPER);
  EXPECT_EQ(properties->id, id_);
  EXPECT_TRUE(properties->has_calibration);
  EXPECT_TRUE(properties->controls_grip);
  EXPECT_TRUE(properties->senses_grip);
  EXPECT_TRUE(properties->controls_position);
}

TEST_F(GrippersTest, PropertiesCanBeReplaced) {
  const Inbox<EndEffectorProperties> inbox("robot/end_effector/left_gripper/properties");
  auto set =
      handle_.advertise<EndEffectorProperties>("robot/end_effector/left_gripper/rsdk/set_properties", 1);
  EndEffectorProperties own;
  own.id = 7;
  own.ui_type = EndEffectorProperties::PASSIVE_GRIPPER;
  own.product = "a hook";
  send_in_vain(set, own);
  EXPECT_TRUE(wait_for([&] { return inbox.count() > 0 && inbox.all().back()->product == "a hook"; }));
  const Inbox<EndEffectorProperties> late("robot/end_effector/left_gripper/properties");
  ASSERT_TRUE(late.wait_for_count(1));
  EXPECT_EQ(late.all().back()->product, "a hook") << "latched";
}

TEST_F(GrippersTest, FollowsPositionCommands) {
  calibrate();
  send(left_, command(EndEffectorCommand::CMD_GO, R"({"position": 40.0})"));
  host_.advance(0.05);
  EXPECT_TRUE(simulator_.gripper_state(Side::kLeft).moving);
  host_.advance(2);
  EXPECT_NEAR(opening(), 40, 5);
  EXPECT_NEAR(opening(Side::kRight), 100, 1) << "the other one stays";
}

TEST_F(GrippersTest, GripsAndReleases) {
  calibrate();
  send(left_, command(EndEffectorCommand::CMD_GRIP));
  host_.advance(2);
  EXPECT_NEAR(opening(), 0, 5);
  send(left_, command(EndEffectorCommand::CMD_RELEASE));
  host_.advance(2);
  EXPECT_NEAR(opening(), 100, 5);
}

TEST_F(GrippersTest, StateEchoesTheLastCommandThatWasTaken) {
  calibrate();
  Inbox<EndEffectorState> states("robot/end_effector/left_gripper/state");
  EXPECT_EQ(next(states)->command, "");
  const auto good = command(EndEffectorCommand::CMD_GO, R"({"position": 40.0})");
  send(left_, good);
  send_in_vain(left_, command(EndEffectorCommand::CMD_GO, R"({"position": 140.0})"));
  send_in_vain(left_, command("dance"));
  host_.advance(2);
  const auto state = next(states);
  EXPECT_EQ(state->command, "go");
  EXPECT_EQ(state->command_sender, "a test");
  EXPECT_EQ(state->command_sequence, good.sequence);
  EXPECT_EQ(state->id, id_);
  EXPECT_NEAR(state->position, 40, 5);
  EXPECT_EQ(state->enabled, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(state->calibrated, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(state->ready, EndEffectorState::STATE_TRUE);
  EXPECT_EQ(state->moving, EndEffectorState::STATE_FALSE);
  EXPECT_NEAR(state->timestamp.toSec(), host_.stamp().toSec(), 0.03);
}

TEST_F(GrippersTest, StateReportsADisabledRobot) {
  Inbox<EndEffectorState> states("robot/end_effector/left_gripper/state");
  simulator_.enable(false);
  EXPECT_EQ(next(states)->enabled, EndEffectorState::STATE_FALSE);
}

TEST_F(GrippersTest, WrongCommandsAreNamed) {
  auto other = command(EndEffectorCommand::CMD_GRIP);
  other.id = 5;
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    left_.publish(other);
    return log_.count("robot/end_effector/left_gripper/command is ignored: id 5") > 0;
  })) << log_.text();
  host_.advance(1);
  EXPECT_NEAR(opening(), 100, 1);
}

TEST_F(GrippersTest, AnUncalibratedGripperAsksForIt) {
  calibrate();
  send(left_, command(EndEffectorCommand::CMD_CLEAR_CALIBRATION));
  host_.advance(0.02);
  EXPECT_FALSE(simulator_.gripper_state(Side::kLeft).calibrated);
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    send(left_, command(EndEffectorCommand::CMD_GRIP));
    host_.advance(0.02);
    return log_.count("not calibrated") > 0;
  })) << log_.text();
  send(left_, command(EndEffectorCommand::CMD_CALIBRATE));
  EXPECT_TRUE(host_.advance_until([&] { return simulator_.gripper_state(Side::kLeft).calibrated; }));
}

TEST_F(GrippersTest, VelocityIsConfigured) {
  calibrate();
  send(left_, command(EndEffectorCommand::CMD_CONFIGURE, R"({"velocity": 10.0, "dead_zone": 1.0})"));
  send(left_, command(EndEffectorCommand::CMD_GRIP));
  host_.advance(0.5);
  const double slow = opening();
  send(left_, command(EndEffectorCommand::CMD_RELEASE));
  host_.advance(3);
  send(left_, command(EndEffectorCommand::CMD_SET, R"({"velocity": 100.0})"));
  send(left_, command(EndEffectorCommand::CMD_GRIP));
  host_.advance(0.5);
  EXPECT_GT(slow, opening() + 20);
}

class GripperActionTest : public GrippersTest {
 protected:
  using Client = actionlib::SimpleActionClient<control_msgs::GripperCommandAction>;

  void SetUp() override {
    ASSERT_TRUE(host_.advance_until([&] { return client_.isServerConnected(); }));
    calibrate();
  }
  void send_goal(double position, double max_effort = 0) {
    GripperCommandGoal goal;
    goal.command.position = position;
    goal.command.max_effort = max_effort;
    const auto before = host_.posted();
    client_.sendGoal(goal, {}, {}, [this](const auto&) { ++feedbacks_; });
    ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
    host_.advance(0.01);
  }
  std::string wait_for_end() {
    EXPECT_TRUE(host_.advance_until([&] { return client_.getState().isDone(); }))
        << client_.getState().toString();
    return client_.getState().toString();
  }

  std::atomic<int> feedbacks_{0};
  Client client_{"robot/end_effector/left_gripper/gripper_action", true};
};

TEST_F(GripperActionTest, ReachesTheOpening) {
  send_goal(30);
  EXPECT_EQ(wait_for_end(), "SUCCEEDED");
  EXPECT_TRUE(client_.getResult()->reached_goal);
  EXPECT_FALSE(client_.getResult()->stalled);
  EXPECT_NEAR(client_.getResult()->position, 30, 5);
  EXPECT_TRUE(wait_for([&] { return feedbacks_ > 5; }));
}

TEST_F(GripperActionTest, CalibratesFirstWhereThatIsMissing) {
  ASSERT_TRUE(simulator_.command_gripper(Side::kLeft, make(Kind::kClearCalibration)));
  send_goal(50);
  EXPECT_EQ(wait_for_end(), "SUCCEEDED") << client_.getState().getText();
  EXPECT_TRUE(simulator_.gripper_state(Side::kLeft).calibrated);
  EXPECT_NEAR(opening(), 50, 5);
}

TEST_F(GripperActionTest, ACancelledCalibrationIsNoMove) {
  ASSERT_TRUE(simulator_.command_gripper(Side::kLeft, make(Kind::kClearCalibration)));
  send_goal(0);
  const auto before = host_.posted();
  client_.cancelGoal();
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
  EXPECT_EQ(wait_for_end(), "PREEMPTED");
}

TEST_F(GripperActionTest, HoldingSomethingIsASuccess) {
  put_cube_between_the_fingers();
  send_goal(0, 50);
  EXPECT_EQ(wait_for_end(), "SUCCEEDED") << client_.getState().getText();
  EXPECT_TRUE(client_.getResult()->stalled);
  EXPECT_FALSE(client_.getResult()->reached_goal);
  EXPECT_GT(client_.getResult()->position, 10) << "as wide as the cube";
}

TEST_F(GripperActionTest, AStuckFingerAbortsInTime) {
  ASSERT_TRUE(simulator_.set_fault({simulate::FaultKind::kJointStuck, "l_gripper_l_finger_joint", 1, 0}));
  const double begin_s = host_.stamp().toSec();
  send_goal(0);
  EXPECT_EQ(wait_for_end(), "ABORTED");
  EXPECT_FALSE(client_.getResult()->reached_goal);
  EXPECT_GE(host_.stamp().toSec() - begin_s, 5);
}

TEST_F(GripperActionTest, WrongGoalsAreRejected) {
  for (const double wrong : {-1.0, 101.0, std::nan("")}) {
    send_goal(wrong);
    EXPECT_EQ(wait_for_end(), "REJECTED") << wrong;
    EXPECT_NE(client_.getState().getText().find("per cent"), std::string::npos);
  }
  send_goal(50, 101);
  EXPECT_EQ(wait_for_end(), "REJECTED");
  simulator_.enable(false);
  send_goal(50);
  EXPECT_EQ(wait_for_end(), "REJECTED");
  EXPECT_NE(client_.getState().getText().find("enable"), std::string::npos);
}

TEST_F(GripperActionTest, ACancelledGoalStopsTheFingers) {
  send(left_, command(EndEffectorCommand::CMD_CONFIGURE, R"({"velocity": 10.0})"));
  send_goal(0);
  host_.advance(0.3);
  const auto before = host_.posted();
  client_.cancelGoal();
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
  EXPECT_EQ(wait_for_end(), "PREEMPTED");
  const double rest = opening();
  EXPECT_GT(rest, 20);
  host_.advance(1);
  EXPECT_NEAR(opening(), rest, 1);
}

TEST_F(GripperActionTest, ADisabledRobotAborts) {
  send_goal(0);
  simulator_.enable(false);
  EXPECT_EQ(wait_for_end(), "ABORTED");
}

TEST_F(GripperActionTest, ANewGoalPreemptsTheOldOne) {
  Client other("robot/end_effector/left_gripper/gripper_action", true);
  ASSERT_TRUE(host_.advance_until([&] { return other.isServerConnected(); }));
  send_goal(0);
  GripperCommandGoal goal;
  goal.command.position = 80;
  const auto before = host_.posted();
  other.sendGoal(goal);
  ASSERT_TRUE(wait_for([&] { return host_.posted() > before; }));
  EXPECT_EQ(wait_for_end(), "PREEMPTED");
  EXPECT_TRUE(host_.advance_until([&] { return other.getState().isDone(); }));
  EXPECT_EQ(other.getState().toString(), "SUCCEEDED");
}

}  // namespace
}  // namespace extperfc::ros_test
