// The ladder of a robot that is stuck.
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "test/unit/navigate/core/fake_robot.hpp"

namespace extperfc::navigate::test {
namespace {

const NavError kCause{NavCode::kBlocked, "an obstacle in front"};

class RecoveryTest : public testing::Test {
 protected:
  RecoveryTest() {
    for (double x = -2; x <= 0; x += 0.1) trail_.push_back({x, 0, 0});
  }
  RecoveryView view() {
    return {now_s_, pose_, pose_, &robot_.costs, &robot_.footprint, &trail_, &robot_.params_.limits};
  }
  /// Until the step is done. The most that it moved [m, rad].
  RecoveryOutput run() {
    for (int i = 0; i < 2000; ++i) {
      const auto output = recovery_.update(view());
      if (output.clear_beyond_m) cleared_ = true;
      if (output.done) return output;
      pose_ = advance(pose_, output.velocity, 0.05);
      EXPECT_NE(contact(robot_.costs, robot_.footprint, pose_), Contact::kObstacle);
      while (!trail_.empty() && std::hypot(trail_.back().x - pose_.x, trail_.back().y - pose_.y) < 0.05)
        trail_.pop_back();
      now_s_ += 0.05;
    }
    ADD_FAILURE() << "the step does not end";
    return {};
  }

  FakeRobot robot_;
  Recovery recovery_{RecoveryParams{}};
  std::deque<Pose2> trail_;
  Pose2 pose_;
  double now_s_{0};
  bool cleared_{false};
};

TEST_F(RecoveryTest, GoesUpTheLadderAndEnds) {
  std::vector<RecoveryStep> steps;
  while (steps.size() < 100) {
    pose_ = {};  // it always comes back here
    if (!recovery_.begin(kCause, view())) break;
    steps.push_back(recovery_.step());
    (void)run();
  }
  const std::vector<RecoveryStep> expected{RecoveryStep::kWait, RecoveryStep::kClear, RecoveryStep::kBackOff,
                                           RecoveryStep::kAvoid, RecoveryStep::kRotate};
  EXPECT_EQ(steps, expected);
  EXPECT_TRUE(cleared_);
  EXPECT_EQ(recovery_.count(), 5);
}

TEST_F(RecoveryTest, BacksOffAlongWhereItCameFrom) {
  trail_.clear();
  for (double y = -2; y <= 0; y += 0.1) trail_.push_back({0, y, 0});
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(recovery_.begin(kCause, view()));
    if (i < 2) (void)run();
  }
  ASSERT_EQ(recovery_.step(), RecoveryStep::kBackOff);
  (void)run();
  EXPECT_NEAR(pose_.y, -0.6, 0.05);
  EXPECT_NEAR(pose_.x, 0, 0.05);
}

TEST_F(RecoveryTest, ADifferentialBaseBacksOffUntilItsTrailLeadsBesideIt) {
  robot_.params_.limits.max_vy_m_s = 0;
  trail_.clear();
  for (double y = -2; y <= 0; y += 0.1) trail_.push_back({-0.3, y, 1.57});
  for (double x = -0.2; x <= 0; x += 0.1) trail_.push_back({x, 0, 0});
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(recovery_.begin(kCause, view()));
    if (i < 2) (void)run();
  }
  ASSERT_EQ(recovery_.step(), RecoveryStep::kBackOff);
  const double began_s = now_s_;
  (void)run();
  EXPECT_LT(pose_.x, -0.15);
  EXPECT_NEAR(pose_.y, 0, 1e-9);
  EXPECT_LT(now_s_ - began_s, 3) << "it does not wait beside its trail";
}

TEST_F(RecoveryTest, DoesNotBackIntoAnObstacleNorRotateWithoutSpace) {
  robot_.block({-0.65, 0}, 0.1);
  robot_.block({0.0, 0.55}, 0.1);
  robot_.block({0.0, -0.55}, 0.1);
  std::vector<RecoveryStep> steps;
  while (recovery_.begin(kCause, view()) && steps.size() < 10) {
    steps.push_back(recovery_.step());
    (void)run();
    EXPECT_GT(pose_.x, -0.2);
    pose_ = {};
    trail_ = {{-1, 0, 0}, {-0.5, 0, 0}};
  }
  EXPECT_LE(steps.size(), 5U);
}

TEST_F(RecoveryTest, AStepThatHelpedMayBeTriedAgainAndAnotherPlaceIsAnotherPlace) {
  ASSERT_TRUE(recovery_.begin(kCause, view()));
  EXPECT_EQ(recovery_.step(), RecoveryStep::kWait);
  recovery_.helped();
  ASSERT_TRUE(recovery_.begin(kCause, view()));
  EXPECT_EQ(recovery_.step(), RecoveryStep::kWait);
  ASSERT_TRUE(recovery_.begin(kCause, view()));
  EXPECT_EQ(recovery_.step(), RecoveryStep::kClear);
  pose_ = {2, 0, 0};
  ASSERT_TRUE(recovery_.begin(kCause, view()));
  EXPECT_EQ(recovery_.step(), RecoveryStep::kWait);
}

TEST_F(RecoveryTest, TheNumberOfAttemptsIsLimited) {
  int count = 0;
  for (; count < 1000 && recovery_.begin(kCause, view()); ++count) pose_.x += 1.0;
  EXPECT_EQ(count, RecoveryParams{}.max_attempts);
  recovery_.advanced();
  EXPECT_TRUE(recovery_.begin(kCause, view()));
}

TEST_F(RecoveryTest, AvoidsThePlaceAhead) {
  std::optional<AvoidedPlace> avoided;
  while (recovery_.begin(kCause, view())) {
    if (const auto output = run(); output.avoid) avoided = output.avoid;
    pose_ = {};  // it drives to the same place again
    trail_ = {{-0.2, 0, 0}, {-0.1, 0, 0}};
  }
  ASSERT_TRUE(avoided);
  EXPECT_GT(avoided->middle_m.x(), 0) << "in the direction in which it drove";
}

TEST_F(RecoveryTest, APersonIsLetPassThenThePassageIsAvoidedInItsWholeWidth) {
  auto seen = view();
  seen.person_m = {1.0, 0.5};
  ASSERT_TRUE(recovery_.begin(kCause, seen));
  EXPECT_EQ(recovery_.step(), RecoveryStep::kWait) << "who walks may be gone soon";
  EXPECT_TRUE(recovery_.may_yield(seen));
  ASSERT_TRUE(recovery_.begin(kCause, seen));
  ASSERT_EQ(recovery_.step(), RecoveryStep::kYield);
  EXPECT_FALSE(recovery_.may_yield(seen));
  ASSERT_TRUE(recovery_.update(seen).yield_to_m);
  EXPECT_EQ(*recovery_.update(seen).yield_to_m, Eigen::Vector2d(1.0, 0.5));
  ASSERT_TRUE(recovery_.begin(kCause, seen));
  ASSERT_EQ(recovery_.step(), RecoveryStep::kAvoid) << "there may be another passage";
  const auto output = recovery_.update(seen);
  ASSERT_TRUE(output.avoid);
  EXPECT_EQ(output.avoid->middle_m, Eigen::Vector2d(1.0, 0.5));
  EXPECT_EQ(output.avoid->radius_m, RecoveryParams{}.avoid_person_m);
}

TEST_F(RecoveryTest, WithoutAPathOrAFreeGoalItYieldsFirstToAPerson) {
  auto seen = view();
  EXPECT_FALSE(recovery_.may_yield(seen)) << "nobody is there";
  seen.person_m = {1.0, 0.5};
  for (const NavCode cause : {NavCode::kNoPath, NavCode::kGoalBlocked}) {
    recovery_.reset();
    ASSERT_TRUE(recovery_.begin({cause, "none"}, seen));
    EXPECT_EQ(recovery_.step(), RecoveryStep::kYield);
    ASSERT_TRUE(recovery_.begin({cause, "none"}, seen));
    EXPECT_EQ(recovery_.step(), RecoveryStep::kClear);
  }
  RecoveryParams params;
  params.back_off_m = 0;
  EXPECT_FALSE(Recovery(params).may_yield(seen)) << "a robot that never drives back does not yield";
}

TEST_F(RecoveryTest, ReasonsNameStepPlaceAndCause) {
  pose_ = {1.25, -0.5, 0};
  EXPECT_EQ(*recovery_.begin(kCause, view()),
            "wait at (1.25, -0.50), because of blocked: an obstacle in front");
}

TEST_F(RecoveryTest, WithoutAPathItDoesNotBackOff) {
  std::vector<RecoveryStep> steps;
  while (recovery_.begin({NavCode::kNoPath, "walls"}, view())) {
    steps.push_back(recovery_.step());
    (void)run();
    pose_ = {};
  }
  const std::vector<RecoveryStep> expected{RecoveryStep::kClear, RecoveryStep::kWait, RecoveryStep::kRotate};
  EXPECT_EQ(steps, expected);
}

TEST(SafeMotion, FreeMotionsAndThoseOutOfAContact) {
  FakeRobot robot;
  robot.block({0.45, 0}, 0.1);  // 5 cm into the footprint
  EXPECT_FALSE(is_safe_motion(robot.costs, robot.footprint, {}, {0.1, 0, 0})) << "deeper";
  EXPECT_TRUE(is_safe_motion(robot.costs, robot.footprint, {}, {-0.1, 0, 0})) << "out of it";
  EXPECT_TRUE(is_safe_motion(robot.costs, robot.footprint, {-0.5, 0, 0}, {-0.4, 0, 0}));
  EXPECT_FALSE(is_safe_motion(robot.costs, robot.footprint, {-0.5, 0, 0}, {0.2, 0, 0}));
  robot.block({0, 0}, 0.3);
  EXPECT_FALSE(is_safe_motion(robot.costs, robot.footprint, {}, {-0.1, 0, 0})) << "too deep to know";
}

TEST(RecoveryParams, OutOfRangeThrows) {
  RecoveryParams params;
  params.rotate_rad_s = 0;
  EXPECT_THROW(Recovery{params}, std::invalid_argument);
  params = {};
  params.max_attempts = 0;
  EXPECT_THROW(Recovery{params}, std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate::test
