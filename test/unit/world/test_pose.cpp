#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/frame_about.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {
namespace {

TEST(Pose, RollPitchYawTurnAboutFixedAxes) {
  // Roll first: z goes to -y, yaw then turns it to +x.
  const Pose pose = make_pose({1, 2, 3}, {M_PI / 2, 0, M_PI / 2});
  const Eigen::Vector3d z = pose * Eigen::Vector3d(0, 0, 1);
  EXPECT_NEAR((z - Eigen::Vector3d(2, 2, 3)).norm(), 0, 1e-12);
}

TEST(Pose, WrappedAnglesLieInTheirRange) {
  EXPECT_NEAR(wrap_angle(3 * M_PI), M_PI, 1e-12);
  EXPECT_NEAR(wrap_angle(-3 * M_PI / 2), M_PI / 2, 1e-12);
  Rng rng(2);
  for (int i = 0; i < 1000; ++i) {
    const double angle = rng.uniform(-50, 50);
    EXPECT_GT(wrap_angle(angle), -M_PI - 1e-12);
    EXPECT_LE(wrap_angle(angle), M_PI + 1e-12);
    EXPECT_NEAR(std::sin(wrap_angle(angle)), std::sin(angle), 1e-9);
  }
}

TEST(Pose, AdvancingDrivesACircle) {
  // 1 m/s and 0.5 rad/s: a circle of 2 m radius, half of it in 2 pi seconds.
  const Pose2 there = advance({0, 0, 0}, {1.0, 0, 0.5}, 2 * M_PI);
  EXPECT_NEAR(there.x, 0, 1e-12);
  EXPECT_NEAR(there.y, 4, 1e-12);
  EXPECT_NEAR(std::abs(there.yaw), M_PI, 1e-12);
}

TEST(Pose, AdvancingInSmallStepsIsTheSame) {
  const Twist2 twist{0.7, -0.3, 0.9};
  Pose2 stepped{1, -2, 0.4};
  const Pose2 whole = advance(stepped, twist, 3.0);
  for (int i = 0; i < 3000; ++i) stepped = advance(stepped, twist, 0.001);
  EXPECT_NEAR(stepped.x, whole.x, 1e-9);
  EXPECT_NEAR(stepped.y, whole.y, 1e-9);
  EXPECT_NEAR(stepped.yaw, whole.yaw, 1e-9);
}

TEST(Pose, AFrameAboutAnAxisTurnsZIntoIt) {
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d axis(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-5, 5));
    const Eigen::Matrix3d frame = frame_about(axis);
    EXPECT_NEAR((frame.col(2) - axis.normalized()).norm(), 0, 1e-12);
    EXPECT_NEAR((frame * frame.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);
  }
  EXPECT_NEAR(frame_about({0, 0, -2})(2, 2), -1, 1e-12);
  EXPECT_TRUE(frame_about({0, 0, 0.5}).isIdentity(1e-12));
}

}  // namespace
}  // namespace extperfc
