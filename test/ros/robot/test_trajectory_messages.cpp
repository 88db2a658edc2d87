// control_msgs/FollowJointTrajectory <-> the follower's types.
#include <gtest/gtest.h>

#include "ros/robot/trajectory_messages.hpp"

namespace extperfc::ros_robot {
namespace {

using control_msgs::FollowJointTrajectoryResult;
using simulate::TrajectoryCode;

TEST(TrajectoryMessages, AGoalKeepsEverything) {
  control_msgs::FollowJointTrajectoryGoal message;
  message.trajectory.joint_names = {"a", "b"};
  message.trajectory.points.resize(1);
  message.trajectory.points[0].positions = {1, 2};
  message.trajectory.points[0].velocities = {3, 4};
  message.trajectory.points[0].accelerations = {5, 6};
  message.trajectory.points[0].time_from_start = ros::Duration(1.5);
  message.trajectory.header.stamp = ros::Time(7.25);
  message.path_tolerance.resize(1);
  message.path_tolerance[0].name = "a";
  message.path_tolerance[0].position = 0.1;
  message.goal_tolerance.resize(1);
  message.goal_tolerance[0].name = "b";
  message.goal_tolerance[0].velocity = -1;
  message.goal_tolerance[0].acceleration = 0.5;
  message.goal_time_tolerance = ros::Duration(0.25);
  const auto goal = from_message(message);
  EXPECT_EQ(goal.joints, message.trajectory.joint_names);
  ASSERT_EQ(goal.points.size(), 1U);
  EXPECT_EQ(goal.points[0].time_s, 1.5);
  EXPECT_EQ(goal.points[0].positions, (std::vector<double>{1, 2}));
  EXPECT_EQ(goal.points[0].velocities, (std::vector<double>{3, 4}));
  EXPECT_EQ(goal.points[0].accelerations, (std::vector<double>{5, 6}));
  EXPECT_EQ(goal.start_s, 7.25);
  EXPECT_EQ(goal.path_tolerance.at(0).joint, "a");
  EXPECT_EQ(goal.path_tolerance.at(0).position, 0.1);
  EXPECT_EQ(goal.goal_tolerance.at(0).velocity, -1);
  EXPECT_EQ(goal.goal_tolerance.at(0).acceleration, 0.5);
  EXPECT_EQ(goal.goal_time_tolerance_s, 0.25);
}

TEST(TrajectoryMessages, AStampOfZeroIsNow) {
  EXPECT_FALSE(from_message(control_msgs::FollowJointTrajectoryGoal()).start_s);
}

TEST(TrajectoryMessages, CodesAreThoseOfTheAction) {
  for (const auto& [code, number] :
       {std::pair{TrajectoryCode::kSuccessful, FollowJointTrajectoryResult::SUCCESSFUL},
        std::pair{TrajectoryCode::kInvalidGoal, FollowJointTrajectoryResult::INVALID_GOAL},
        std::pair{TrajectoryCode::kInvalidJoints, FollowJointTrajectoryResult::INVALID_JOINTS},
        std::pair{TrajectoryCode::kOldHeaderTimestamp, FollowJointTrajectoryResult::OLD_HEADER_TIMESTAMP},
        std::pair{TrajectoryCode::kPathToleranceViolated,
                  FollowJointTrajectoryResult::PATH_TOLERANCE_VIOLATED},
        std::pair{TrajectoryCode::kGoalToleranceViolated,
                  FollowJointTrajectoryResult::GOAL_TOLERANCE_VIOLATED}}) {
    const auto message = to_message(simulate::TrajectoryEnd{code, "why"});
    EXPECT_EQ(message.error_code, number);
    EXPECT_EQ(message.error_string, "why");
  }
}

TEST(TrajectoryMessages, FeedbackHasTheDifference) {
  const simulate::JointMotion desired{Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4), Eigen::Vector2d(5, 6)};
  const simulate::JointMotion actual{Eigen::Vector2d(0.5, 1), Eigen::Vector2d(1, 1), Eigen::Vector2d(1, 2)};
  const auto message = feedback_message({{"a"}, {"b"}}, desired, actual, ros::Time(3));
  EXPECT_EQ(message.header.stamp, ros::Time(3));
  EXPECT_EQ(message.joint_names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(message.desired.positions, (std::vector<double>{1, 2}));
  EXPECT_EQ(message.actual.velocities, (std::vector<double>{1, 1}));
  EXPECT_EQ(message.error.positions, (std::vector<double>{0.5, 1}));
  EXPECT_EQ(message.error.velocities, (std::vector<double>{2, 3}));
  EXPECT_EQ(message.error.accelerations, (std::vector<double>{4, 4}));
}

}  // namespace
}  // namespace extperfc::ros_robot
