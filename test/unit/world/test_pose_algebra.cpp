#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {
namespace {

constexpr int kTrials = 500;
constexpr double kTiny = 1e-9;

Pose2 random_pose(Rng& rng) {
  return {rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-M_PI, M_PI)};
}

void expect_same(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x, b.x, kTiny);
  EXPECT_NEAR(a.y, b.y, kTiny);
  EXPECT_NEAR(wrap_angle(a.yaw - b.yaw), 0, kTiny);
}

TEST(PoseAlgebra, ComposesByHand) {
  // One metre ahead and two to the left of a robot at (3, 4) that looks along +y.
  expect_same(compose({3, 4, M_PI / 2}, {1, 2, M_PI / 2}), {1, 5, M_PI});
  expect_same(inverse({3, 4, M_PI / 2}), {-4, 3, -M_PI / 2});
  expect_same(between({3, 4, M_PI / 2}, {3, 6, M_PI}), {2, 0, M_PI / 2});
}

TEST(PoseAlgebra, AgreesWithTransformsInSpace) {
  Rng rng(1);
  for (int i = 0; i < kTrials; ++i) {
    const Pose2 a = random_pose(rng);
    const Pose2 b = random_pose(rng);
    EXPECT_TRUE((to_pose(a) * to_pose(b)).isApprox(to_pose(compose(a, b)), kTiny)) << "trial " << i;
    EXPECT_TRUE(to_pose(a).inverse().isApprox(to_pose(inverse(a)), kTiny)) << "trial " << i;
  }
}

TEST(PoseAlgebra, LawsOfAGroup) {
  Rng rng(2);
  for (int i = 0; i < kTrials; ++i) {
    const Pose2 a = random_pose(rng);
    const Pose2 b = random_pose(rng);
    const Pose2 c = random_pose(rng);
    expect_same(compose(compose(a, b), c), compose(a, compose(b, c)));
    expect_same(compose(a, inverse(a)), {});
    expect_same(compose(inverse(a), a), {});
    expect_same(inverse(inverse(a)), a);
    expect_same(compose(a, between(a, b)), b);
    expect_same(inverse(between(a, b)), between(b, a));
    EXPECT_GT(compose(a, b).yaw, -M_PI - kTiny);
    EXPECT_LE(compose(a, b).yaw, M_PI + kTiny);
  }
}

}  // namespace
}  // namespace extperfc
