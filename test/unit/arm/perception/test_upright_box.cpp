// Boxes without their tilt, and the shapes in them.
#include <cmath>
#include <variant>

#include <gtest/gtest.h>

#include "extperfc/arm/upright_box.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {
namespace {

const Eigen::Vector3d kSize(0.1, 0.2, 0.3);

TEST(UprightBox, WhatStandsStaysAsItIs) {
  for (const double yaw : {-3.0, -1.0, 0.0, 0.4, 1.6, 3.1}) {
    const Pose pose = make_pose({1, 2, 3}, {0, 0, yaw});
    const auto box = make_upright(pose, kSize);
    EXPECT_TRUE(pose_of(box).isApprox(pose, 1e-12)) << yaw;
    EXPECT_EQ(kSize, box.size_m);
  }
}

TEST(UprightBox, ALittleTiltGoesAndTheYawStays) {
  const auto box = make_upright(make_pose({0, 0, 0}, {0.1, -0.1, 0.7}), kSize);
  EXPECT_NEAR(0.7, box.yaw_rad, 0.02);
  EXPECT_EQ(kSize, box.size_m);
}

TEST(UprightBox, ABoxAlongTheAxesOfACameraGetsItsHeightInZ) {
  // x to the right, y down, z ahead; the camera looks along the world's x axis and a little down.
  Eigen::Matrix3d optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()).toRotationMatrix() * optical;
  const auto box = make_upright(pose, kSize);
  EXPECT_TRUE(box.size_m.isApprox(Eigen::Vector3d(0.3, 0.1, 0.2)));  // along the view, across it, upwards
  EXPECT_NEAR(0.0, box.yaw_rad, 1e-12);
}

TEST(UprightBox, OfQuarterRotationsNothingButTheOrderOfTheSizesRemains) {
  // The corners of an axis-aligned box that is turned by quarters fill the same space afterwards.
  Rng rng(7);
  for (int i = 0; i < 200; ++i) {
    Pose pose = make_pose({1, 0, 0});
    for (int k = 0; k < 5; ++k)
      pose.rotate(Eigen::AngleAxisd(M_PI_2 * std::floor(rng.uniform(0.0, 4.0)),
                                    Eigen::Vector3d::Unit(static_cast<Eigen::Index>(rng.uniform(0.0, 3.0)))));
    const auto box = make_upright(pose, kSize);
    const Eigen::Vector3d wanted = (pose.linear() * kSize).cwiseAbs();
    const Eigen::Vector3d found = (pose_of(box).linear() * box.size_m).cwiseAbs();
    EXPECT_TRUE(found.isApprox(wanted, 1e-9)) << i << ": " << found.transpose();
  }
}

TEST(UprightBox, Shapes) {
  const auto sphere = std::get<Sphere>(shape_in(UprightKind::kSphere, kSize));
  EXPECT_DOUBLE_EQ(0.15, sphere.radius_m);
  const auto cylinder = std::get<Cylinder>(shape_in(UprightKind::kCylinder, kSize));
  EXPECT_DOUBLE_EQ(0.1, cylinder.radius_m);
  EXPECT_DOUBLE_EQ(0.3, cylinder.length_m);
  const auto cone = std::get<Cone>(shape_in(UprightKind::kCone, kSize));
  EXPECT_DOUBLE_EQ(0.1, cone.radius_m);
  EXPECT_DOUBLE_EQ(0.3, cone.height_m);
  EXPECT_EQ(kSize, std::get<Box>(shape_in(UprightKind::kBox, kSize)).size_m);
}

}  // namespace
}  // namespace extperfc::arm
