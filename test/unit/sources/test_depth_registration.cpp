#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "extperfc/base/rng.hpp"

#include "sources/depth_registration.hpp"

namespace extperfc::sources {
namespace {

CameraModel camera(int width, int height, double f) {
  return {width, height, f, f, 0.5 * (width - 1), 0.5 * (height - 1), {}};
}

cv::Mat constant(int width, int height, std::uint16_t value) {
  return {height, width, CV_16UC1, cv::Scalar(value)};
}

TEST(DepthRegistration, SameCameraChangesNothing) {
  const auto same = camera(64, 48, 60.0);
  cv::Mat depth(48, 64, CV_16UC1);
  Rng rng(1);
  for (auto& value : cv::Mat_<std::uint16_t>(depth)) value = static_cast<std::uint16_t>(rng.integer(0, 4000));
  const auto out = DepthRegistration(same, same, Eigen::Isometry3d::Identity()).apply(depth, 0.001);
  EXPECT_EQ(cv::countNonZero(out != depth), 0);
}

TEST(DepthRegistration, UnitsBecomeMillimetres) {
  const auto same = camera(8, 8, 10.0);
  const auto out =
      DepthRegistration(same, same, Eigen::Isometry3d::Identity()).apply(constant(8, 8, 5000), 0.0002);
  EXPECT_EQ(out.at<std::uint16_t>(4, 4), 1000);
}

TEST(DepthRegistration, SidewaysOffsetShiftsByTheDisparity) {
  const auto same = camera(100, 20, 100.0);
  cv::Mat depth = cv::Mat::zeros(20, 100, CV_16UC1);
  depth.at<std::uint16_t>(10, 50) = 2000;
  Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
  shift.translation().x() = 0.1;  // 0.1 m at 2 m and f = 100 px: 5 px
  const auto out = DepthRegistration(same, same, shift).apply(depth, 0.001);
  EXPECT_EQ(cv::countNonZero(out), 1);
  EXPECT_EQ(out.at<std::uint16_t>(10, 55), 2000);
}

TEST(DepthRegistration, DenserColourImageHasNoHoles) {
  const auto out =
      DepthRegistration(camera(32, 24, 30.0), camera(96, 72, 90.0), Eigen::Isometry3d::Identity())
          .apply(constant(32, 24, 1500), 0.001);
  EXPECT_EQ(cv::countNonZero(out == 1500), 96 * 72);
}

TEST(DepthRegistration, NearestSurfaceWins) {
  const auto same = camera(100, 1, 100.0);
  cv::Mat depth = cv::Mat::zeros(1, 100, CV_16UC1);
  depth.at<std::uint16_t>(0, 40) = 1000;  // moves by 10 px
  depth.at<std::uint16_t>(0, 45) = 2000;  // moves by 5 px, to the same place
  Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
  shift.translation().x() = 0.1;
  EXPECT_EQ(DepthRegistration(same, same, shift).apply(depth, 0.001).at<std::uint16_t>(0, 50), 1000);
}

TEST(DepthRegistration, PointsBehindOrOutsideTheColourCameraAreLeftOut) {
  const auto same = camera(16, 16, 20.0);
  Eigen::Isometry3d back = Eigen::Isometry3d::Identity();
  back.translation().z() = -5.0;
  EXPECT_EQ(cv::countNonZero(DepthRegistration(same, same, back).apply(constant(16, 16, 1000), 0.001)), 0);
  Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
  aside.translation().x() = 1e6;
  EXPECT_EQ(cv::countNonZero(DepthRegistration(same, same, aside).apply(constant(16, 16, 1000), 0.001)), 0);
}

}  // namespace
}  // namespace extperfc::sources
