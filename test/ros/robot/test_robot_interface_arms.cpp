// Joint commands and states of the arms.
#include <baxter_core_msgs/EndpointState.h>
#include <baxter_core_msgs/SEAJointState.h>
#include <std_msgs/Float64.h>
#include <trajectory_msgs/JointTrajectoryPoint.h>

#include "test/ros/robot/joint_command.hpp"
#include "test/ros/robot/robot_test.hpp"

namespace extperfc::ros_test {
namespace {

using baxter_core_msgs::JointCommand;

constexpr int kS0 = 0;
constexpr int kE1 = 3;
constexpr int kW2 = 6;

std_msgs::Float64 number(double value) {
  std_msgs::Float64 message;
  message.data = value;
  return message;
}

class ArmsTest : public RobotTest {
 protected:
  /// Repeats a command at 100 Hz of simulated time, as Baxter wants it.
  void hold(const JointCommand& message, double duration_s) {
    for (double t = 0; t < duration_s; t += 0.01) {
      send(left_, message);
      host_.advance(0.01);
    }
  }

  ros::Publisher left_ = handle_.advertise<JointCommand>("robot/limb/left/joint_command", 10);
};

TEST_F(ArmsTest, PositionModeMovesToThePosition) {
  const double from = position(Side::kLeft, kW2);
  const auto right = positions(Side::kRight);
  const auto message = joint_command(JointCommand::POSITION_MODE, {"left_w2"}, {from + 0.3});
  hold(message, 1);
  EXPECT_GT(position(Side::kLeft, kW2), from + 0.2) << "limited to a fraction of the speed, but on its way";
  EXPECT_EQ(positions(Side::kRight), right);
}

TEST_F(ArmsTest, JointsThatAreNotNamedStay) {
  const auto before = positions(Side::kLeft);
  hold(joint_command(JointCommand::RAW_POSITION_MODE, {"left_w2", "left_e1"},
                     {before[kW2] + 0.1, before[kE1] - 0.1}),
       0.3);
  const auto after = positions(Side::kLeft);
  EXPECT_NEAR(after[kW2], before[kW2] + 0.1, 1e-3);
  EXPECT_NEAR(after[kE1], before[kE1] - 0.1, 1e-3);
  for (const int still : {0, 1, 2, 4, 5}) EXPECT_NEAR(after[still], before[still], 1e-6) << still;
}

TEST_F(ArmsTest, VelocityModeMovesUntilTheTimeIsOver) {
  const auto message = joint_command(JointCommand::VELOCITY_MODE, {"left_s0"}, {0.5});
  hold(message, 0.5);
  EXPECT_NEAR(velocity(Side::kLeft, kS0), 0.5, 0.01);
  host_.advance(0.15);
  EXPECT_NEAR(velocity(Side::kLeft, kS0), 0.5, 0.01) << "a command counts for 0.2 s";
  host_.advance(0.3);
  EXPECT_NEAR(velocity(Side::kLeft, kS0), 0, 1e-6) << "held, as nothing came";
}

TEST_F(ArmsTest, TheTimeOfACommandCanBeChanged) {
  auto timeout = handle_.advertise<std_msgs::Float64>("robot/limb/left/joint_command_timeout", 1);
  send(timeout, number(1.0));
  host_.advance(0.01);
  send(left_, joint_command(JointCommand::VELOCITY_MODE, {"left_s0"}, {0.3}));
  host_.advance(0.9);
  EXPECT_NEAR(velocity(Side::kLeft, kS0), 0.3, 0.01);
  host_.advance(0.3);
  EXPECT_NEAR(velocity(Side::kLeft, kS0), 0, 1e-6);
}

TEST_F(ArmsTest, TheSpeedRatioSlowsPositionModeDown) {
  auto ratio = handle_.advertise<std_msgs::Float64>("robot/limb/left/set_speed_ratio", 1);
  const double from = position(Side::kLeft, kW2);
  const auto message = joint_command(JointCommand::POSITION_MODE, {"left_w2"}, {from + 2});
  send(ratio, number(0.1));
  hold(message, 0.5);
  const double slow = velocity(Side::kLeft, kW2);
  EXPECT_NEAR(slow, 0.4, 0.02) << "a tenth of 4 rad/s";
  send(ratio, number(0.3));
  hold(message, 0.5);
  EXPECT_NEAR(velocity(Side::kLeft, kW2), 1.2, 0.05);
}

TEST_F(ArmsTest, WrongRatiosAndTimesAreIgnored) {
  auto ratio = handle_.advertise<std_msgs::Float64>("robot/limb/left/set_speed_ratio", 10);
  auto timeout = handle_.advertise<std_msgs::Float64>("robot/limb/left/joint_command_timeout", 10);
  for (const double wrong : {-0.1, 1.1, std::nan("")}) send_in_vain(ratio, number(wrong));
  for (const double wrong : {0.0, 1.1, std::nan("")}) send_in_vain(timeout, number(wrong));
  const auto before = host_.posted();
  send(ratio, number(0.3));
  send(timeout, number(0.2));
  EXPECT_EQ(host_.posted(), before + 2) << "only the good ones, which came last";
}

TEST_F(ArmsTest, ADisabledArmStaysAndSaysSo) {
  simulator_.enable(false);
  const auto before = positions(Side::kLeft);
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    send(left_, joint_command(JointCommand::RAW_POSITION_MODE, {"left_s0"}, {before[kS0] + 0.1}));
    host_.advance(0.05);
    return log_.count("robot/limb/left/joint_command is ignored: the robot is disabled") > 0;
  })) << log_.text();
  EXPECT_EQ(positions(Side::kLeft), before);
}

TEST_F(ArmsTest, WrongCommandsAreIgnoredAndNamed) {
  const auto before = positions(Side::kLeft);
  const auto wrong = joint_command(JointCommand::RAW_POSITION_MODE, {"left_s0", "right_s1"}, {1.0, 0.0});
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    left_.publish(wrong);
    return log_.count("robot/limb/left/joint_command is ignored: 'right_s1' is not a joint of this arm") > 0;
  })) << log_.text();
  host_.advance(0.1);
  EXPECT_EQ(positions(Side::kLeft), before) << "nothing of a wrong command is done";
}

TEST_F(ArmsTest, TorqueNeedsDynamicArms) {
  EXPECT_TRUE(wait_for([&] {  // until the log is connected
    send(left_, joint_command(JointCommand::TORQUE_MODE, {"left_s0"}, {1.0}));
    host_.advance(0.05);
    return log_.count("torque mode needs dynamic arms") > 0;
  })) << log_.text();
}

TEST_F(ArmsTest, TheEndPointIsWhereTheLinksAre) {
  Inbox<baxter_core_msgs::EndpointState> states("robot/limb/left/endpoint_state");
  const auto message = next(states);
  EXPECT_EQ(message->header.frame_id, "base");
  EXPECT_NEAR(message->header.stamp.toSec(), host_.stamp().toSec(), 0.03);
  // The published pose of the untucked arm.
  EXPECT_NEAR(message->pose.position.x, 0.579711, 2e-3);
  EXPECT_NEAR(message->pose.position.y, 0.183294, 2e-3);
  EXPECT_NEAR(message->pose.position.z, 0.1137, 2e-3);
  const auto& q = message->pose.orientation;
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  EXPECT_NEAR(rotation(0, 0), -0.959067, 2e-3);
  EXPECT_NEAR(rotation(1, 0), 0.27922, 2e-3);
  EXPECT_NEAR(rotation(2, 2), -0.998428, 2e-3);
}

TEST_F(ArmsTest, TheEndPointsVelocityIsThatOfItsPositions) {
  Inbox<baxter_core_msgs::EndpointState> states("robot/limb/left/endpoint_state");
  ASSERT_TRUE(wait_for([&] { return states.connected(); }));
  hold(joint_command(JointCommand::VELOCITY_MODE, {"left_s0"}, {0.5}), 0.5);
  ASSERT_TRUE(wait_for([&] {
    return states.count() > 0 && states.all().back()->header.stamp > host_.stamp() - ros::Duration(0.02);
  }));
  const auto all = states.all();
  const auto& last = *all[all.size() - 1];
  const auto& earlier = *all[all.size() - 6];
  const double passed = (last.header.stamp - earlier.header.stamp).toSec();
  EXPECT_NEAR((last.pose.position.y - earlier.pose.position.y) / passed, last.twist.linear.y, 0.02);
  EXPECT_NEAR(last.twist.angular.z, 0.5, 0.01) << "s0 turns about the vertical axis";
}

TEST_F(ArmsTest, GravityTorquesListEveryJoint) {
  Inbox<baxter_core_msgs::SEAJointState> torques("robot/limb/right/gravity_compensation_torques");
  const auto message = next(torques);
  ASSERT_EQ(message->name.size(), 7U);
  EXPECT_EQ(message->name.front(), "right_s0");
  for (const auto* list :
       {&message->commanded_position, &message->commanded_velocity, &message->commanded_acceleration,
        &message->commanded_effort, &message->actual_position, &message->actual_velocity,
        &message->actual_effort, &message->gravity_model_effort, &message->gravity_only,
        &message->hysteresis_model_effort, &message->crosstalk_model_effort})
    EXPECT_EQ(list->size(), 7U);
  EXPECT_NEAR(message->actual_position[kE1], position(Side::kRight, kE1), 1e-6);
}

TEST_F(ArmsTest, StatesComeAHundredTimesPerSecond) {
  const Inbox<baxter_core_msgs::EndpointState> endpoints("robot/limb/right/endpoint_state");
  const Inbox<baxter_core_msgs::SEAJointState> torques("robot/limb/left/gravity_compensation_torques");
  ASSERT_TRUE(wait_for([&] { return endpoints.connected() && torques.connected(); }));
  host_.advance(1);
  EXPECT_TRUE(endpoints.wait_for_count(100));
  EXPECT_TRUE(torques.wait_for_count(100));
  EXPECT_TRUE(never([&] { return endpoints.count() > 100 || torques.count() > 100; }, 0.2));
}

TEST_F(ArmsTest, FeedForwardIsTaken) {
  const auto publisher =
      handle_.advertise<trajectory_msgs::JointTrajectoryPoint>("robot/limb/left/inverse_dynamics_command", 1);
  EXPECT_TRUE(wait_for([&] { return publisher.getNumSubscribers() > 0; }));
}

}  // namespace
}  // namespace extperfc::ros_test
