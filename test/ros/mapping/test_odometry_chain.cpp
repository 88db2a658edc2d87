#include <cmath>

#include <gtest/gtest.h>

#include "ros/mapping/odometry_chain.hpp"

namespace extperfc::ros_mapping {
namespace {

void expect_same(const Pose2& a, const Pose2& b, double tolerance = 1e-9) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(wrap_angle(a.yaw - b.yaw), 0, tolerance);
}

TEST(OdometryChain, WithoutJumpsItIsOdometry) {
  OdometryChain chain({});
  Pose2 pose{4, -2, 3};
  for (int i = 0; i < 100; ++i) {
    const auto step = chain.next(0.1 * i, pose, std::nullopt);
    ASSERT_TRUE(step.odom_T_base);
    EXPECT_FALSE(step.jumped);
    expect_same(*step.odom_T_base, pose);
    pose = compose(pose, {0.05, 0.01, 0.1});
  }
}

TEST(OdometryChain, AJumpIsNoMotion) {
  OdometryChain chain({});
  (void)chain.next(0, Pose2{0, 0, 0}, std::nullopt);
  (void)chain.next(0.1, Pose2{0.1, 0, 0}, std::nullopt);
  const auto jump = chain.next(0.2, Pose2{50, 20, 1}, std::nullopt);
  EXPECT_TRUE(jump.jumped);
  EXPECT_FALSE(jump.odom_T_base) << "how far the robot went is not known";
  const auto after = chain.next(0.3, compose({50, 20, 1}, {0.1, 0, 0}), std::nullopt);
  ASSERT_TRUE(after.odom_T_base);
  expect_same(*after.odom_T_base, {0.2, 0, 0});
}

TEST(OdometryChain, RotationsJumpToo) {
  OdometryChain chain({5.0, 10.0});
  (void)chain.next(0, Pose2{}, std::nullopt);
  EXPECT_TRUE(chain.next(0.1, Pose2{0, 0, 2.5}, std::nullopt).jumped);
  EXPECT_FALSE(chain.next(0.2, Pose2{0, 0, 3.5}, std::nullopt).jumped);
}

TEST(OdometryChain, AJumpDependsOnTheTimeThatPassed) {
  OdometryChain chain({1.0, 1.0});
  (void)chain.next(0, Pose2{}, std::nullopt);
  EXPECT_FALSE(chain.next(10, Pose2{9, 0, 0}, std::nullopt).jumped) << "a pause";
  EXPECT_TRUE(chain.next(10.5, Pose2{18, 0, 0}, std::nullopt).jumped);
  EXPECT_FALSE(chain.next(10.4, Pose2{18.1, 0, 0}, std::nullopt).jumped) << "a stamp that runs back a little";
  EXPECT_TRUE(chain.next(10.5, Pose2{std::nan(""), 0, 0}, std::nullopt).jumped);
}

TEST(OdometryChain, MissingOdometryIsBridgedByTheNext) {
  OdometryChain chain({});
  (void)chain.next(0, Pose2{1, 0, 0}, std::nullopt);
  EXPECT_FALSE(chain.next(0.1, std::nullopt, std::nullopt).odom_T_base);
  const auto next = chain.next(0.2, Pose2{1.2, 0, 0}, std::nullopt);
  ASSERT_TRUE(next.odom_T_base);
  expect_same(*next.odom_T_base, {1.2, 0, 0});
}

TEST(OdometryChain, ANewBeginningIsUnknownMotion) {
  OdometryChain chain({});
  (void)chain.next(0, Pose2{1, 0, 0}, std::nullopt);
  chain.forget();
  const auto first = chain.next(100, Pose2{1.1, 7, 2}, std::nullopt);
  EXPECT_FALSE(first.odom_T_base);
  EXPECT_FALSE(first.jumped);
  const auto second = chain.next(100.1, compose({1.1, 7, 2}, {0.1, 0, 0}), std::nullopt);
  ASSERT_TRUE(second.odom_T_base);
  expect_same(*second.odom_T_base, {1.1, 0, 0});
}

TEST(OdometryChain, RotationIsTheImus) {
  OdometryChain chain({});
  const Pose2 true_step{0.1, 0, 0.2};
  Pose2 truth{};
  Pose2 odometry{};
  double yaw = 1.7;
  (void)chain.next(0, odometry, yaw);
  for (int i = 1; i <= 20; ++i) {
    truth = compose(truth, advance({}, {0.1, 0, 0.2}, 1.0));
    odometry = compose(odometry, advance({}, {0.1, 0, 0.1}, 1.0));  // odometry sees half of the rotation
    yaw += true_step.yaw;
    const auto step = chain.next(i, odometry, yaw);
    ASSERT_TRUE(step.odom_T_base);
    EXPECT_TRUE(step.yaw_from_imu);
    expect_same(*step.odom_T_base, truth, 2e-3);  // an arc's chord shortens by rotation^2 / 24
  }
}

TEST(OdometryChain, AnImuThatIsMissingForOneStepCostsTwoRotations) {
  OdometryChain chain({});
  (void)chain.next(0, Pose2{}, 0.0);
  EXPECT_FALSE(chain.next(1, Pose2{}, std::nullopt).yaw_from_imu);
  EXPECT_FALSE(chain.next(2, Pose2{}, 0.5).yaw_from_imu);
  const auto step = chain.next(3, Pose2{}, 0.7);
  EXPECT_TRUE(step.yaw_from_imu);
  EXPECT_NEAR(step.odom_T_base->yaw, 0.2, 1e-12);
}

}  // namespace
}  // namespace extperfc::ros_mapping
