#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <opencv2/core.hpp>

#include "extperfc/sources/recording.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

namespace fs = std::filesystem;
using mrpt::obs::CObservation3DRangeScan;

constexpr char kExample[] = "/usr/share/mrpt/datasets/tests_rgbd.rawlog";

/// A range image of 8 x 6 pixels, all at `millimetres`, and a grey image of `intensity`.
CObservation3DRangeScan::Ptr make_scan(int millimetres, std::uint8_t intensity = 50) {
  auto scan = CObservation3DRangeScan::Create();
  scan->timestamp = mrpt::Clock::fromDouble(1000.0 + millimetres);
  scan->hasRangeImage = true;
  scan->rangeImage_setSize(6, 8);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x) scan->rangeImage(y, x) = static_cast<std::uint16_t>(millimetres);
  scan->hasIntensityImage = true;
  scan->intensityImage.resize(8, 6, mrpt::img::CH_GRAY);
  scan->intensityImage.filledRectangle(0, 0, 7, 5, mrpt::img::TColor(intensity, intensity, intensity));
  scan->cameraParams.ncols = 8;
  scan->cameraParams.nrows = 6;
  scan->cameraParams.setIntrinsicParamsFromValues(10.0, 10.0, 3.5, 2.5);
  scan->cameraParamsIntensity = scan->cameraParams;
  return scan;
}

template <typename... Objects>
void write_rawlog(const fs::path& file, const Objects&... objects) {
  mrpt::io::CFileGZOutputStream stream(file.string());
  auto archive = mrpt::serialization::archiveFrom(stream);
  (archive.WriteObject(objects.get()), ...);
}

int depth_at(const Result<RgbdFrame>& frame, int x, int y) {
  return frame->depth.at<std::uint16_t>(y, x);
}

TEST(Rawlog, FramesInAnyOrderAnyNumberOfTimes) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "a.rawlog";
  auto moment = mrpt::obs::CSensoryFrame::Create();
  moment->insert(make_scan(2000));
  moment->insert(mrpt::obs::CObservationOdometry::Create());
  moment->insert(make_scan(3000));
  write_rawlog(file, make_scan(1000), mrpt::obs::CObservationOdometry::Create(), moment, make_scan(4000));
  const auto recording = open_rawlog(file);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ((*recording)->size(), 4U);
  ASSERT_TRUE((*recording)->camera());
  EXPECT_DOUBLE_EQ((*recording)->camera()->fx, 10.0);
  for (const int index : {0, 1, 2, 3, 2, 0, 3, 3}) {
    const auto frame = (*recording)->frame(static_cast<std::size_t>(index));
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(depth_at(frame, 3, 3), 1000 * (index + 1));
    EXPECT_NEAR(frame->stamp_s, 1000.0 + 1000.0 * (index + 1), 1e-3);
    EXPECT_EQ(frame->color.type(), CV_8UC1);
    EXPECT_EQ(frame->color.at<std::uint8_t>(1, 1), 50);
    EXPECT_EQ(frame->label, "a.rawlog#" + std::to_string(index));
  }
  EXPECT_EQ((*recording)->frame(4).error().code, ErrorCode::kInvalidArgument);
}

TEST(Rawlog, RangesAlongRaysBecomeDepth) {
  const TemporaryFolder folder;
  const auto scan = make_scan(1000);
  scan->range_is_depth = false;
  scan->rangeUnits = 0.002F;
  write_rawlog(folder.path() / "a.rawlog", scan);
  const auto frame = (*open_rawlog(folder.path() / "a.rawlog"))->frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_NEAR(depth_at(frame, 0, 0), 2000.0 / std::sqrt(1.0 + 0.35 * 0.35 + 0.25 * 0.25), 2.0);
}

TEST(Rawlog, DepthIsMovedIntoTheColourCamera) {
  const TemporaryFolder folder;
  const auto scan = make_scan(1000);
  for (int y = 0; y < 6; ++y) scan->rangeImage(y, 2) = 500;
  // The colour camera stands 0.1 m to the right of the depth camera (-y in MRPT's sensor frame): at 1 m and
  // f = 10 px everything moves 1 px to the left, at 0.5 m 2 px.
  scan->relativePoseIntensityWRTDepth.y(-0.1);
  write_rawlog(folder.path() / "a.rawlog", scan);
  const auto frame = (*open_rawlog(folder.path() / "a.rawlog"))->frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(depth_at(frame, 0, 3), 500);
  EXPECT_EQ(depth_at(frame, 1, 3), 0);  // hidden from the depth camera
  EXPECT_EQ(depth_at(frame, 2, 3), 1000);
  EXPECT_EQ(depth_at(frame, 6, 3), 1000);
  EXPECT_EQ(depth_at(frame, 7, 3), 0);  // outside of the depth image
}

TEST(Rawlog, PartsThatAreMissingStayEmpty) {
  const TemporaryFolder folder;
  const auto only_depth = make_scan(1000);
  only_depth->hasIntensityImage = false;
  const auto only_color = make_scan(1000);
  only_color->hasRangeImage = false;
  write_rawlog(folder.path() / "a.rawlog", only_depth, only_color);
  const auto recording = open_rawlog(folder.path() / "a.rawlog");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE((*recording)->frame(0)->color.empty());
  EXPECT_EQ((*recording)->frame(0)->depth.cols, 8);
  EXPECT_TRUE((*recording)->frame(1)->depth.empty());
  EXPECT_EQ((*recording)->frame(1)->color.cols, 8);
}

TEST(Rawlog, SeparatelyStoredImagesAreFoundOrNamed) {
  const TemporaryFolder folder;
  const auto images = folder.path() / "a_Images";
  fs::create_directories(images);
  const auto scan = make_scan(1000, 80);
  ASSERT_TRUE(scan->intensityImage.saveToFile((images / "one.png").string()));
  scan->intensityImage.setExternalStorage("one.png");
  write_rawlog(folder.path() / "a.rawlog", scan);
  const auto recording = open_rawlog(folder.path() / "a.rawlog");
  ASSERT_TRUE(recording) << recording.error().message;
  const auto frame = (*recording)->frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->color.at<std::uint8_t>(2, 2), 80);
  fs::remove(images / "one.png");
  const auto missing = (*recording)->frame(0);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("one.png"), std::string::npos) << missing.error().message;
}

TEST(Rawlog, DamagedEndIsReportedAfterTheGoodFrames) {
  const TemporaryFolder folder;
  const auto whole = folder.path() / "whole.rawlog";
  mrpt::io::CFileOutputStream stream(whole.string());  // not compressed, so that it can be cut anywhere
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive.WriteObject(make_scan(1000).get());
  archive.WriteObject(make_scan(2000).get());
  stream.close();
  fs::resize_file(whole, fs::file_size(whole) - 40);
  const auto recording = open_rawlog(whole);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ((*recording)->size(), 2U);
  EXPECT_TRUE((*recording)->frame(0));
  const auto broken = (*recording)->frame(1);
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().code, ErrorCode::kCorrupt);
  EXPECT_TRUE((*recording)->frame(0));
}

TEST(Rawlog, FilesThatCannotBePlayed) {
  const TemporaryFolder folder;
  EXPECT_EQ(open_rawlog(folder.path() / "none.rawlog").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(open_rawlog(folder.write("text.rawlog", "this is no rawlog, only text")).error().code,
            ErrorCode::kCorrupt);
  write_rawlog(folder.path() / "odometry.rawlog", mrpt::obs::CObservationOdometry::Create());
  const auto odometry = open_rawlog(folder.path() / "odometry.rawlog");
  ASSERT_FALSE(odometry);
  EXPECT_EQ(odometry.error().code, ErrorCode::kNotFound);
  EXPECT_NE(odometry.error().message.find("CObservation3DRangeScan"), std::string::npos);
}

TEST(Rawlog, ExampleOfMrpt) {
  if (!fs::exists(kExample)) GTEST_SKIP() << kExample << " (Debian package mrpt-common) is not installed";
  const auto recording = open_rawlog(kExample);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ((*recording)->size(), 1U);
  ASSERT_TRUE((*recording)->camera());
  EXPECT_NEAR((*recording)->camera()->fx, 521.18, 0.01);
  const auto frame = (*recording)->frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->color.type(), CV_8UC3);
  EXPECT_EQ(frame->color.size(), cv::Size(640, 480));
  EXPECT_EQ(frame->depth.size(), frame->color.size());
  EXPECT_GT(cv::countNonZero(frame->depth), 640 * 480 / 3);
  double farthest_mm = 0.0;
  cv::minMaxLoc(frame->depth, nullptr, &farthest_mm);
  EXPECT_LT(farthest_mm, 12000.0);
}

}  // namespace
}  // namespace extperfc::sources
