// Depth images by stamp.
#include <thread>

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

#include "ros/face/depth_frames.hpp"

namespace extperfc::ros_test {
namespace {

using ros_face::DepthFrames;

constexpr double kLongS = 60.0;  // no test waits it out
constexpr double kToleranceS = 0.02;

sensor_msgs::ImagePtr frame_at(double stamp_s) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(stamp_s);
  return image;
}

TEST(DepthFrames, TheNearestWithinTheTolerance) {
  DepthFrames frames(10);
  for (const double stamp_s : {1.0, 1.03, 1.06}) frames.put(frame_at(stamp_s));
  const auto found = frames.find(ros::Time(1.02), kToleranceS, kLongS);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->header.stamp, ros::Time(1.03));
  EXPECT_FALSE(frames.find(ros::Time(0.9), kToleranceS, kLongS)) << "passed: no reason to wait";
}

TEST(DepthFrames, OnlyTheLatestAreKept) {
  DepthFrames frames(2);
  for (const double stamp_s : {1.0, 2.0, 3.0}) frames.put(frame_at(stamp_s));
  EXPECT_FALSE(frames.find(ros::Time(1.0), kToleranceS, kLongS));
  EXPECT_TRUE(frames.find(ros::Time(2.0), kToleranceS, kLongS));
}

TEST(DepthFrames, WaitsForOneThatMayStillCome) {
  DepthFrames frames(10);
  frames.put(frame_at(1.0));
  std::thread camera([&] { frames.put(frame_at(1.1)); });
  EXPECT_TRUE(frames.find(ros::Time(1.1), kToleranceS, kLongS));
  camera.join();
}

TEST(DepthFrames, ASilentCameraIsWaitedForOnce) {
  DepthFrames frames(10);
  EXPECT_FALSE(frames.find(ros::Time(1.0), kToleranceS, kLongS)) << "no image ever came";
  frames.put(frame_at(1.0));
  EXPECT_FALSE(frames.find(ros::Time(2.0), kToleranceS, 0.01));
  EXPECT_FALSE(frames.find(ros::Time(3.0), kToleranceS, kLongS)) << "still silent";
}

TEST(DepthFrames, ABagThatBeginsAgainIsANewTime) {
  DepthFrames frames(10);
  frames.put(frame_at(100.0));
  frames.put(frame_at(1.0));
  EXPECT_FALSE(frames.find(ros::Time(100.0), kToleranceS, 0.01));
  EXPECT_TRUE(frames.find(ros::Time(1.0), kToleranceS, kLongS));
}

TEST(DepthFrames, CloseEndsAWait) {
  DepthFrames frames(10);
  frames.put(frame_at(1.0));
  std::thread closer([&] { frames.close(); });
  EXPECT_FALSE(frames.find(ros::Time(2.0), kToleranceS, kLongS));
  closer.join();
}

}  // namespace
}  // namespace extperfc::ros_test
