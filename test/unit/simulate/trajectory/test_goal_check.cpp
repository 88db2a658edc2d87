// Every error of a goal, and what is made of a good one.
#include <functional>
#include <limits>
#include <ostream>

#include <gtest/gtest.h>

#include "simulate/trajectory/goal_check.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNow = 100;

std::vector<FollowedJoint> two_joints() {
  return {{"shoulder", -1, 1}, {"elbow", 0, 2}};
}

TrajectoryGoal good_goal() {
  TrajectoryGoal goal;
  goal.joints = {"shoulder", "elbow"};
  goal.points = {{0.5, {0.1, 0.2}, {0, 0}, {0, 0}}, {1.0, {0.3, 0.4}, {0, 0}, {0, 0}}};
  return goal;
}

TrajectoryResult<CheckedGoal> check(const TrajectoryGoal& goal) {
  return check_goal(goal, two_joints(), TrajectoryFollowerParams{}, kNow);
}

struct Fault {
  const char* name;
  std::function<void(TrajectoryGoal&)> make;
  TrajectoryCode code;
  const char* message;  ///< part of what is said
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

class RefusedGoalTest : public testing::TestWithParam<Fault> {};

TEST_P(RefusedGoalTest, SaysWhy) {
  auto goal = good_goal();
  GetParam().make(goal);
  const auto checked = check(goal);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, GetParam().code) << checked.error().message;
  EXPECT_NE(checked.error().message.find(GetParam().message), std::string::npos) << checked.error().message;
}

using Goal = TrajectoryGoal;
constexpr auto kBad = TrajectoryCode::kInvalidGoal;
constexpr auto kJoints = TrajectoryCode::kInvalidJoints;

INSTANTIATE_TEST_SUITE_P(
    All, RefusedGoalTest,
    testing::Values(
        Fault{"subset", [](Goal& g) { g.joints = {"shoulder"}; }, kJoints, "elbow is missing"},
        Fault{"no_joints", [](Goal& g) { g.joints.clear(); }, kJoints, "this arm wants shoulder elbow"},
        Fault{"unknown",
              [](Goal& g) {
                g.joints = {"shoulder", "elbow", "knee"};
              },
              kJoints, "'knee'"},
        Fault{"twice",
              [](Goal& g) {
                g.joints = {"shoulder", "elbow", "elbow"};
              },
              kJoints, "elbow is given twice"},
        Fault{"no_points", [](Goal& g) { g.points.clear(); }, kBad, "no points"},
        Fault{"size", [](Goal& g) { g.points[1].positions = {1}; }, kBad,
              "point 1: positions has 1 values for 2"},
        Fault{"velocity_size",
              [](Goal& g) {
                g.points[0].velocities = {1, 2, 3};
              },
              kBad, "point 0: velocities"},
        Fault{"acceleration_size", [](Goal& g) { g.points[0].accelerations = {1}; }, kBad,
              "accelerations has 1"},
        Fault{"acceleration_only", [](Goal& g) { g.points[0].velocities.clear(); }, kBad,
              "without velocities"},
        Fault{"nan", [](Goal& g) { g.points[0].positions[1] = kNan; }, kBad, "not finite"},
        Fault{"infinite_velocity", [](Goal& g) { g.points[0].velocities[1] = kInfinity; }, kBad,
              "not finite"},
        Fault{"nan_time", [](Goal& g) { g.points[1].time_s = kNan; }, kBad, "point 1: its time"},
        Fault{"negative_time", [](Goal& g) { g.points[0].time_s = -0.1; }, kBad, "point 0: its time"},
        Fault{"equal_times", [](Goal& g) { g.points[1].time_s = 0.5; }, kBad, "0.500 s is not after"},
        Fault{"back_in_time", [](Goal& g) { g.points[1].time_s = 0.2; }, kBad, "0.200 s is not after"},
        Fault{"above_limit", [](Goal& g) { g.points[1].positions[1] = 2.1; }, kBad, "elbow at 2.100 rad"},
        Fault{"below_limit", [](Goal& g) { g.points[1].positions[0] = -1.1; }, kBad, "[-1.000, 1.000]"},
        Fault{"over", [](Goal& g) { g.start_s = kNow - 1.5; }, TrajectoryCode::kOldHeaderTimestamp,
              "0.500 s ago"},
        Fault{"other_clock", [](Goal& g) { g.start_s = 1.7e9; }, kBad, "use_sim_time"},
        Fault{"nan_start", [](Goal& g) { g.start_s = kNan; }, kBad, "starts"},
        Fault{"goal_time", [](Goal& g) { g.goal_time_tolerance_s = -1; }, kBad, "goal_time_tolerance"},
        Fault{"path_joint",
              [](Goal& g) {
                g.path_tolerance = {{"knee", 1, 0, 0}};
              },
              kJoints, "path_tolerance names 'knee'"},
        Fault{"goal_joint",
              [](Goal& g) {
                g.goal_tolerance = {{"knee", 1, 0, 0}};
              },
              kJoints, "goal_tolerance names 'knee'"},
        Fault{"nan_tolerance",
              [](Goal& g) {
                g.goal_tolerance = {{"elbow", kNan, 0, 0}};
              },
              kBad, "elbow is not a number"}),
    [](const auto& test) { return test.param.name; });

TEST(GoalCheck, PutsJointsInOrder) {
  auto goal = good_goal();
  goal.joints = {"elbow", "shoulder"};
  const auto checked = check(goal);
  ASSERT_TRUE(checked) << checked.error().message;
  ASSERT_EQ(checked->knots.size(), 2U);
  EXPECT_EQ(checked->knots[0].position, Eigen::Vector2d(0.2, 0.1));
  EXPECT_EQ(checked->knots[0].time_s, kNow + 0.5);
  EXPECT_EQ(checked->start_s, kNow);
}

TEST(GoalCheck, LimitsMayBeRounded) {
  auto goal = good_goal();
  goal.points[1].positions = {1.0005, 2.0005};
  EXPECT_TRUE(check(goal));
}

TEST(GoalCheck, LeavesOutWhatIsOver) {
  auto goal = good_goal();
  goal.start_s = kNow - 0.7;
  const auto checked = check(goal);
  ASSERT_TRUE(checked) << checked.error().message;
  ASSERT_EQ(checked->knots.size(), 1U);
  EXPECT_NEAR(checked->knots[0].time_s, kNow + 0.3, 1e-9);
}

TEST(GoalCheck, TolerancesAreGivenStandardOrNone) {
  auto goal = good_goal();
  goal.path_tolerance = {{"elbow", 0.5, 0, 3}};
  goal.goal_tolerance = {{"shoulder", -1, -1, 0}, {"elbow", 0, 0.1, 0}};
  const TrajectoryFollowerParams params;
  const auto checked = check(goal);
  ASSERT_TRUE(checked) << checked.error().message;
  EXPECT_EQ(checked->path_bounds.position, Eigen::Vector2d(params.path_tolerance_rad, 0.5));
  EXPECT_EQ(checked->path_bounds.velocity, Eigen::Vector2d(kInfinity, kInfinity));
  EXPECT_EQ(checked->path_bounds.acceleration, Eigen::Vector2d(kInfinity, 3));
  EXPECT_EQ(checked->goal_bounds.position, Eigen::Vector2d(kInfinity, params.goal_tolerance_rad));
  EXPECT_EQ(checked->goal_bounds.velocity, Eigen::Vector2d(kInfinity, 0.1));
  EXPECT_EQ(checked->goal_time_s, params.goal_time_s);
}

}  // namespace
}  // namespace extperfc::simulate
