// A follower with joints that follow their set points, or do not.
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "extperfc/simulate/trajectory_follower.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kStep = 1.0 / 240.0;

/// One joint and its follower. `plant` makes a measured position of the set point; the ideal one by default.
class FollowerTest : public testing::Test {
 protected:
  void start(const TrajectoryGoal& goal) {
    const auto started = follower_.start(goal, now_s_, measured_);
    ASSERT_TRUE(started) << started.error().message;
  }

  /// Steps until the goal ends or the time is over.
  std::optional<TrajectoryEnd> run(double duration_s) {
    const auto steps = static_cast<int>(std::round(duration_s / kStep));
    for (int i = 0; i < steps; ++i)
      if (auto end = step()) return end;
    return std::nullopt;
  }

  std::optional<TrajectoryEnd> step() {
    const double wanted =
        follower_.moving() ? follower_.desired(now_s_ + kStep).position[0] : measured_.position[0];
    const double position = plant_(wanted);
    fastest_ = std::max(fastest_, std::abs(position - measured_.position[0]) / kStep);
    measured_.velocity[0] = (position - measured_.position[0]) / kStep;
    measured_.position[0] = position;
    now_s_ += kStep;
    return follower_.update(now_s_, measured_);
  }

  [[nodiscard]] double position() const { return measured_.position[0]; }

  static TrajectoryGoal goal_to(double position, double time_s) {
    TrajectoryGoal goal;
    goal.joints = {"elbow"};
    goal.points = {{time_s, {position}, {0}, {}}};
    return goal;
  }

  double now_s_{10};
  double fastest_{0};  ///< [rad/s]
  JointMotion measured_{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)};
  std::function<double(double)> plant_{[](double wanted) { return wanted; }};
  TrajectoryFollowerParams params_;
  TrajectoryFollower follower_{{{"elbow"}}, params_};
};

TEST_F(FollowerTest, GetsThereInTimeAndNotBefore) {
  start(goal_to(1, 2));
  EXPECT_FALSE(run(1.0));
  EXPECT_NEAR(position(), 0.5, 1e-3) << "half way of a cubic from rest to rest";
  EXPECT_NEAR(follower_.measured().velocity[0], 0.75, 0.01);
  EXPECT_FALSE(run(0.99));
  const auto end = run(0.1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << end->message;
  EXPECT_NEAR(position(), 1, 1e-9);
  EXPECT_FALSE(follower_.moving());
  EXPECT_FALSE(run(1)) << "an end is reported once";
}

TEST_F(FollowerTest, AStuckJointViolatesThePath) {
  plant_ = [](double wanted) { return std::min(wanted, 0.1); };
  start(goal_to(1, 1));
  const auto end = run(2);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kPathToleranceViolated);
  EXPECT_EQ(end->message.rfind("elbow is 0.2", 0), 0U) << end->message;
  EXPECT_NE(end->message.find("(tolerance 0.200)"), std::string::npos) << end->message;
  EXPECT_LT(now_s_, 11) << "at once, not at the end";
}

TEST_F(FollowerTest, AWiderPathToleranceIsRespected) {
  plant_ = [](double wanted) { return std::min(wanted, 0.1); };
  auto goal = goal_to(0.35, 1);
  goal.path_tolerance = {{"elbow", 0.3, 0, 0}};
  start(goal);
  const auto end = run(2);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalToleranceViolated) << end->message;
  EXPECT_NEAR(now_s_, 11 + params_.goal_time_s, 2 * kStep);
}

TEST_F(FollowerTest, VelocityAndAccelerationOfThePathCanBeBound) {
  auto goal = goal_to(1, 1);
  plant_ = [this](double wanted) { return wanted + (now_s_ > 10.5 ? 0.01 : 0.0); };  // a jerk of 2.4 rad/s
  goal.path_tolerance = {{"elbow", 0, 1, 0}};
  start(goal);
  const auto end = run(2);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kPathToleranceViolated);
  EXPECT_NE(end->message.find("rad/s off its velocity"), std::string::npos) << end->message;
  goal.path_tolerance = {{"elbow", 0, 0, 100}};
  goal.points.front().positions = {0};
  start(goal);
  plant_ = [this](double wanted) { return wanted + (now_s_ > 11 ? 0.01 : 0.0); };
  const auto second = run(2);
  ASSERT_TRUE(second);
  EXPECT_NE(second->message.find("rad/s^2 off its acceleration"), std::string::npos) << second->message;
}

TEST_F(FollowerTest, AnEarlyGoalToleranceWaitsForTheGoalTime) {
  double behind = 0.05;
  plant_ = [&](double wanted) { return wanted - behind; };
  auto goal = goal_to(1, 1);
  goal.goal_time_tolerance_s = 1;
  start(goal);
  EXPECT_FALSE(run(1.5));
  behind = 0.005;
  const auto end = run(0.5);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful) << end->message;
}

TEST_F(FollowerTest, AGoalThatMovesIsNotReached) {
  start(goal_to(0, 0.5));
  plant_ = [this](double) {
    return 0.005 * std::sin(100 * now_s_);
  };  // within half a degree, up to 0.5 rad/s
  auto goal = goal_to(0, 0.5);
  goal.goal_tolerance = {{"elbow", 0, 1e-3, 0}};
  start(goal);
  const auto end = run(1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kGoalToleranceViolated);
  EXPECT_NE(end->message.find("velocity"), std::string::npos) << end->message;
}

TEST_F(FollowerTest, AFarFirstPointAtTimeZeroViolatesThePath) {
  auto goal = goal_to(1, 1);
  goal.points.insert(goal.points.begin(), {0, {0.5}, {0}, {}});
  start(goal);
  const auto end = follower_.update(now_s_, measured_);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kPathToleranceViolated) << end->message;
  EXPECT_FALSE(run(1));
  EXPECT_NEAR(position(), 0, 1e-12) << "nothing moved";
}

TEST_F(FollowerTest, AStartInTheFutureIsWaitedFor) {
  auto goal = goal_to(1, 1);
  goal.start_s = now_s_ + 2;
  start(goal);
  EXPECT_FALSE(run(2));
  EXPECT_EQ(position(), 0);
  const auto end = run(1.1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful);
  EXPECT_NEAR(now_s_, 13, 2 * kStep);
}

TEST_F(FollowerTest, AStartInThePastBeginsInTheMiddle) {
  TrajectoryGoal goal = goal_to(0.2, 1);
  goal.points = {{1, {0.4}, {}, {}}, {2, {0.1}, {}, {}}, {3, {0.3}, {}, {}}};
  goal.start_s = now_s_ - 1.5;
  start(goal);
  EXPECT_FALSE(run(0.5));
  EXPECT_NEAR(position(), 0.1, 2e-3) << "the second point, the first was over";
  const auto end = run(1.1);
  ASSERT_TRUE(end);
  EXPECT_NEAR(now_s_, 11.5, 2 * kStep);
  EXPECT_NEAR(position(), 0.3, 1e-9);
}

TEST_F(FollowerTest, StoppingSlowsDown) {
  start(goal_to(2, 2));
  EXPECT_FALSE(run(1));
  const double speed = measured_.velocity[0];
  const double from = position();
  ASSERT_NEAR(speed, 1.5, 0.02);
  follower_.stop(now_s_);
  EXPECT_FALSE(follower_.following());
  EXPECT_TRUE(follower_.moving());
  EXPECT_FALSE(run(1)) << "what was given up has no end";
  EXPECT_FALSE(follower_.moving());
  EXPECT_NEAR(position() - from, speed * speed / (2 * params_.stop_deceleration_rad_s2), 0.01);
}

TEST_F(FollowerTest, ANewGoalGoesOnSmoothly) {
  start(goal_to(1, 1));
  EXPECT_FALSE(run(0.5));
  const double speed = measured_.velocity[0];
  start(goal_to(-1, 2));
  EXPECT_FALSE(step());
  EXPECT_NEAR(measured_.velocity[0], speed, 0.1) << "no jerk";
  const auto end = run(2.1);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful);
  EXPECT_NEAR(position(), -1, 1e-9);
}

TEST_F(FollowerTest, ARefusedGoalLeavesTheOldOneAlone) {
  start(goal_to(1, 1));
  EXPECT_FALSE(run(0.5));
  EXPECT_FALSE(follower_.start({}, now_s_, measured_));
  const auto end = run(0.6);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kSuccessful);
}

TEST_F(FollowerTest, AGoalInTheFutureSlowsTheOldOneDownFirst) {
  start(goal_to(2, 2));
  EXPECT_FALSE(run(1));
  auto goal = goal_to(0, 2);
  goal.start_s = now_s_ + 1;
  start(goal);
  EXPECT_FALSE(run(1));
  EXPECT_NEAR(measured_.velocity[0], 0, 1e-9);
  EXPECT_TRUE(follower_.following());
  ASSERT_TRUE(run(2.1));
  EXPECT_NEAR(position(), 0, 1e-9);
}

TEST_F(FollowerTest, AfterAViolationItRestsWhereTheJointIs) {
  plant_ = [](double wanted) { return std::min(wanted, 0.1); };
  start(goal_to(1, 1));
  ASSERT_TRUE(run(2));
  plant_ = [](double wanted) { return wanted; };
  EXPECT_FALSE(run(1));
  EXPECT_FALSE(follower_.moving());
  EXPECT_NEAR(position(), 0.1, 0.01);
}

TEST_F(FollowerTest, AClockThatGoesBackEndsTheMotion) {
  start(goal_to(1, 1));
  EXPECT_FALSE(run(0.5));
  now_s_ -= 5;
  const auto end = step();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->code, TrajectoryCode::kPathToleranceViolated);
  EXPECT_NE(end->message.find("clock"), std::string::npos);
  EXPECT_FALSE(follower_.moving());
  start(goal_to(0, 1));
  EXPECT_TRUE(run(1.1)) << "and it works on";
}

TEST_F(FollowerTest, DroppedIsIdleAtOnce) {
  start(goal_to(1, 1));
  EXPECT_FALSE(run(0.5));
  follower_.drop();
  EXPECT_FALSE(follower_.moving());
  EXPECT_FALSE(run(1));
}

TEST(TrajectoryFollower, LeadsJointsInItsOwnOrder) {
  TrajectoryFollower follower({{"a"}, {"b"}}, {});
  TrajectoryGoal goal;
  goal.joints = {"b", "a"};
  goal.points = {{1, {0.2, 0.1}, {}, {}}};
  const JointMotion measured{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  ASSERT_TRUE(follower.start(goal, 0, measured));
  EXPECT_TRUE(follower.desired(0.5).position.isApprox(Eigen::Vector2d(0.05, 0.1)));
}

}  // namespace
}  // namespace extperfc::simulate
