// Poses on the floor as messages.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_convert {
namespace {

constexpr double kTiny = 1e-12;

Pose2 random_pose(Rng& rng) {
  return {rng.uniform(-1e3, 1e3), rng.uniform(-1e3, 1e3), rng.uniform(-M_PI, M_PI)};
}

TEST(PlanarPose, ThereAndBackIsTheSame) {
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const auto pose = random_pose(rng);
    for (const auto& back : {to_pose2(to_pose_message(pose)), to_pose2(to_transform_message(pose))}) {
      ASSERT_TRUE(back);
      EXPECT_NEAR(back->x, pose.x, kTiny);
      EXPECT_NEAR(back->y, pose.y, kTiny);
      EXPECT_NEAR(wrap_angle(back->yaw - pose.yaw), 0, 1e-9);
    }
  }
}

TEST(PlanarPose, AQuaternionOfAnyLengthAndSignCounts) {
  auto message = to_pose_message({1, 2, 0.7});
  for (const double scale : {-1.0, 0.01, 30.0}) {
    auto scaled = message;
    scaled.orientation.z *= scale;
    scaled.orientation.w *= scale;
    EXPECT_NEAR(to_pose2(scaled)->yaw, 0.7, kTiny) << scale;
  }
}

TEST(PlanarPose, HeightRollAndPitchAreLeftOut) {
  geometry_msgs::Pose message;
  message.position.z = 3;
  // roll 0.2 after yaw 0.7: yaw stays
  message.orientation.w = std::cos(0.35) * std::cos(0.1);
  message.orientation.x = std::cos(0.35) * std::sin(0.1);
  message.orientation.y = std::sin(0.35) * std::sin(0.1);
  message.orientation.z = std::sin(0.35) * std::cos(0.1);
  EXPECT_NEAR(to_pose2(message)->yaw, 0.7, kTiny);
}

TEST(PlanarPose, WhatIsNoPoseIsRefused) {
  geometry_msgs::Pose message;
  EXPECT_NE(to_pose2(message).error().message.find("length zero"), std::string::npos);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    message = to_pose_message({});
    message.position.x = bad;
    EXPECT_NE(to_pose2(message).error().message.find("not finite"), std::string::npos);
    message = to_pose_message({});
    message.position.z = bad;
    EXPECT_FALSE(to_pose2(message));
    message = to_pose_message({});
    message.orientation.z = bad;
    EXPECT_FALSE(to_pose2(message));
  }
}

TEST(PlanarPose, CovarianceThereAndBack) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    Eigen::Matrix3d covariance;
    for (Eigen::Index k = 0; k < 9; ++k) covariance(k) = rng.uniform(-1, 1);
    const auto message = to_covariance_message(covariance);
    EXPECT_EQ(to_covariance(message), covariance);
    double sum = 0;
    for (const double value : message) sum += std::abs(value);
    EXPECT_NEAR(sum, covariance.cwiseAbs().sum(), kTiny) << "z, roll and pitch have none";
  }
}

TEST(PlanarPose, CovarianceStandsWhereTheMessageHasIt) {
  Eigen::Matrix3d covariance;
  covariance << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  const auto message = to_covariance_message(covariance);
  EXPECT_EQ(message[0], 1);
  EXPECT_EQ(message[1], 2);
  EXPECT_EQ(message[5], 3);
  EXPECT_EQ(message[7], 5);
  EXPECT_EQ(message[11], 6);
  EXPECT_EQ(message[30], 7);
  EXPECT_EQ(message[35], 9);
}

}  // namespace
}  // namespace extperfc::ros_convert
