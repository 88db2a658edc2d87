// Recordings are played as an RGB-D camera would publish them.
#include <filesystem>

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>
#include <ros/package.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/sources/recording.hpp"

#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/recording.hpp"
#include "test/ros/support/simulated_time.hpp"
#include "test/ros/support/watch.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

constexpr std::size_t kFrames = 6;
constexpr const char* kRgbdRawlog = "/usr/share/mrpt/datasets/tests_rgbd.rawlog";

class SourceTest : public testing::Test {
 protected:
  void load(const Params& more, const std::string& type = "image_pair_source") {
    Params params{{"path", folder_.path().string()}, {"rate_hz", 50.0}, {"loop", false}};
    for (const auto& [key, value] : more) params[key] = value;
    ASSERT_TRUE(manager_.load("/source", type, params)) << log_.text();
  }

  [[nodiscard]] bool played_to_its_end() const {
    return diagnostics_.wait([](const Report& r) { return r.message() == "played to its end"; });
  }

  template <typename M>
  static std::vector<ros::Time> stamps(const Inbox<M>& inbox) {
    std::vector<ros::Time> all;
    for (const auto& message : inbox.all()) all.push_back(message->header.stamp);
    return all;
  }

  /// All four topics carried these frames, with one stamp each.
  void expect_four_topics(std::size_t frames) const {
    ASSERT_TRUE(color_.wait_for_count(frames));
    ASSERT_TRUE(depth_.wait_for_count(frames));
    ASSERT_TRUE(color_info_.wait_for_count(frames));
    ASSERT_TRUE(depth_info_.wait_for_count(frames));
    const auto of_color = stamps(color_);
    EXPECT_EQ(of_color.size(), frames);
    EXPECT_EQ(stamps(depth_), of_color);
    EXPECT_EQ(stamps(color_info_), of_color);
    EXPECT_EQ(stamps(depth_info_), of_color);
    EXPECT_TRUE(std::is_sorted(of_color.begin(), of_color.end()));
    EXPECT_EQ(color_.all().front()->header.frame_id, kFrame);
    EXPECT_EQ(depth_.all().front()->header.frame_id, kFrame);
  }

  TemporaryFolder folder_;
  Inbox<sensor_msgs::Image> color_{"camera/color/image_raw"};
  Inbox<sensor_msgs::Image> depth_{"camera/aligned_depth_to_color/image_raw"};
  Inbox<sensor_msgs::CameraInfo> color_info_{"camera/color/camera_info"};
  Inbox<sensor_msgs::CameraInfo> depth_info_{"camera/aligned_depth_to_color/camera_info"};
  DiagnosticsWatch diagnostics_{"source"};
  LogWatch log_;
  Manager manager_;
};

/// Left edge of the red square of a frame.
int square_at(const sensor_msgs::ImageConstPtr& image) {
  const cv::Mat bgr = cv_bridge::toCvShare(image, "bgr8")->image;
  for (int x = 0; x < bgr.cols; ++x)
    if (bgr.at<cv::Vec3b>(90, x)[2] > 200) return x;
  return -1;
}

TEST_F(SourceTest, EqualNamesArePlayedOnceAndInOrder) {
  write_recording(folder_.path(), kFrames);
  load({});
  ASSERT_TRUE(played_to_its_end());
  expect_four_topics(kFrames);
  for (std::size_t i = 0; i < kFrames; ++i)
    EXPECT_EQ(square_at(color_.all()[i]), kSquare.x + 10 * static_cast<int>(i));
  EXPECT_EQ(color_.all().front()->encoding, "bgr8");
  const auto depth = cv_bridge::toCvShare(depth_.all().front(), "16UC1")->image;
  EXPECT_EQ(depth.at<std::uint16_t>(90, 100), 1000);
  EXPECT_EQ(depth.at<std::uint16_t>(10, 10), 2000);
  EXPECT_EQ(diagnostics_.latest().number("frames"), static_cast<long>(kFrames));
  EXPECT_EQ(diagnostics_.latest().number("played"), static_cast<long>(kFrames));
  EXPECT_TRUE(never([this] { return color_.count() > kFrames; })) << "loop is false";
}

TEST_F(SourceTest, TumAssociationsWithTheirStampsAndScale) {
  write_tum_recording(folder_.path(), kFrames);
  load({{"recorded_stamps", true}, {"depth_scale", 5000.0}});
  ASSERT_TRUE(played_to_its_end());
  expect_four_topics(kFrames);
  for (std::size_t i = 0; i < kFrames; ++i)
    EXPECT_NEAR(color_.all()[i]->header.stamp.toSec(), 100.0 + 0.1 * static_cast<double>(i), 1e-6);
  const auto depth = cv_bridge::toCvShare(depth_.all().front(), "16UC1")->image;
  EXPECT_EQ(depth.at<std::uint16_t>(90, 100), 1000) << "millimetres, whatever the file has";
}

TEST_F(SourceTest, KeepsItsRate) {
  write_recording(folder_.path(), kFrames);
  load({{"rate_hz", 10.0}});
  ASSERT_TRUE(played_to_its_end());
  const auto all = stamps(color_);
  ASSERT_EQ(all.size(), kFrames);
  // A busy machine may delay the first or the last frame, but never make the recording shorter than it is.
  constexpr double kWakeUpS = 0.25;
  EXPECT_GT((all.back() - all.front()).toSec(), 0.1 * (kFrames - 1) - kWakeUpS);
}

TEST_F(SourceTest, RateZeroIsTheRecordedOne) {
  write_tum_recording(folder_.path(), kFrames);
  load({{"rate_hz", 0.0}});
  ASSERT_TRUE(played_to_its_end());
  const auto all = stamps(color_);
  ASSERT_EQ(all.size(), kFrames);
  EXPECT_GT((all.back() - all.front()).toSec(), 0.25);
}

TEST_F(SourceTest, LoopStartsAgain) {
  write_recording(folder_.path(), 2);
  load({{"loop", true}});
  ASSERT_TRUE(color_.wait_for_count(7));
  const auto all = color_.all();
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(square_at(all[i]), kSquare.x + 10 * static_cast<int>(i % 2));
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.message() == "playing"; }));
}

TEST_F(SourceTest, DiagnosticsGoOnAfterTheClockRanBack) {
  write_recording(folder_.path(), 2);
  load({{"loop", true}});
  ASSERT_TRUE(diagnostics_.goes_on());
  const SimulatedTime earlier(10.0);
  EXPECT_TRUE(diagnostics_.goes_on()) << "not only when the time of before is reached";
}

TEST_F(SourceTest, AnUnreadableImageIsNamedAndPassedOver) {
  write_recording(folder_.path(), 3);
  std::filesystem::resize_file(folder_.path() / "rgb" / "1.png", 20);
  load({});
  EXPECT_TRUE(
      diagnostics_.wait([](const Report& r) { return r.is_warning_about("1 frames could not be read"); }));
  EXPECT_TRUE(log_.wait("1.png")) << log_.text();
  ASSERT_TRUE(color_.wait_for_count(2));
  EXPECT_TRUE(never([this] { return color_.count() > 2; }, 0.3));
}

TEST_F(SourceTest, FolderOfUnreadableImagesStaysCalm) {
  write_recording(folder_.path(), 1);
  std::filesystem::resize_file(folder_.path() / "rgb" / "0.png", 20);
  load({{"loop", true}, {"wait_for_subscriber", false}});
  ASSERT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.number("unreadable") >= 1; }));
  constexpr long kFewMore = 5;  // about one a second, where a loop without a pause would make thousands
  const long before = diagnostics_.latest().number("unreadable");
  EXPECT_TRUE(never([&] { return diagnostics_.latest().number("unreadable") > before + kFewMore; }));
}

TEST_F(SourceTest, CalibrationOfTheFolderIsUsed) {
  write_recording(folder_.path(), 2);
  write_camera_info(folder_.path() / "camera_info.yaml", 321.5);
  load({});
  ASSERT_TRUE(color_info_.wait_for_count(1));
  const auto info = color_info_.all().front();
  EXPECT_DOUBLE_EQ(info->K[0], 321.5);
  EXPECT_DOUBLE_EQ(info->K[2], 160.0);
  EXPECT_EQ(info->width, 320U);
  EXPECT_EQ(info->distortion_model, "plumb_bob");
  EXPECT_EQ(log_.count("brings no intrinsics"), 0U);
}

TEST_F(SourceTest, AFileOrNumbersOverrideTheFoldersCalibration) {
  write_recording(folder_.path(), 2);
  write_camera_info(folder_.path() / "camera_info.yaml", 321.5);
  write_camera_info(folder_.path() / "better.yaml", 400.0);
  load({{"camera_info", (folder_.path() / "better.yaml").string()}});
  ASSERT_TRUE(color_info_.wait_for_count(1));
  EXPECT_DOUBLE_EQ(color_info_.all().front()->K[0], 400.0);
  manager_.unload("/source");
  color_info_.clear();
  load({{"width", 320}, {"height", 240}, {"fx", 500.0}, {"fy", 501.0}, {"cx", 150.0}, {"cy", 110.0}});
  ASSERT_TRUE(color_info_.wait_for_count(1));
  EXPECT_DOUBLE_EQ(color_info_.all().front()->K[0], 500.0);
  EXPECT_DOUBLE_EQ(color_info_.all().front()->K[4], 501.0);
}

TEST_F(SourceTest, AnAssumedCameraIsSaidToBeOne) {
  write_recording(folder_.path(), 2);
  load({});
  ASSERT_TRUE(color_info_.wait_for_count(1));
  EXPECT_NEAR(color_info_.all().front()->K[0], 525.0 / 640.0 * 320.0, 1e-9);
  EXPECT_TRUE(log_.wait("brings no intrinsics: assuming fx = fy = 262.5 px")) << log_.text();
}

TEST(SourceWithoutListener, WaitsForOne) {
  TemporaryFolder folder;
  write_recording(folder.path(), kFrames);
  const DiagnosticsWatch diagnostics("source");
  Manager manager;
  ASSERT_TRUE(manager.load("/source", "image_pair_source",
                           {{"path", folder.path().string()}, {"loop", false}, {"rate_hz", 50.0}}));
  ASSERT_TRUE(diagnostics.wait([](const Report&) { return true; }));
  EXPECT_TRUE(never([&] { return diagnostics.latest().number("played") > 0; }));
  const Inbox<sensor_msgs::Image> color("camera/color/image_raw");
  ASSERT_TRUE(color.wait_for_count(kFrames)) << "the first frame must not be missed";
}

TEST_F(SourceTest, RawlogIsPlayed) {
  if (!std::filesystem::exists(kRgbdRawlog)) GTEST_SKIP() << "no " << kRgbdRawlog << ": install mrpt-common";
  if (const auto opened = sources::open_rawlog(kRgbdRawlog);
      !opened && opened.error().code == ErrorCode::kUnsupported)
    GTEST_SKIP() << opened.error().message;
  load({{"path", kRgbdRawlog}, {"loop", true}}, "rawlog_source");
  ASSERT_TRUE(color_.wait_for_count(3)) << log_.text();
  ASSERT_TRUE(depth_.wait_for_count(3));
  const auto color = color_.all().front();
  const auto depth = depth_.all().front();
  const auto info = color_info_.all().front();
  EXPECT_EQ(depth->encoding, "16UC1");
  EXPECT_EQ(depth->width, color->width);
  EXPECT_EQ(depth->height, color->height);
  EXPECT_EQ(info->width, color->width);
  EXPECT_GT(info->K[0], 0.0);
  const auto pixels = cv_bridge::toCvShare(depth, "16UC1")->image;
  EXPECT_GT(cv::countNonZero(pixels), 0.1 * static_cast<double>(pixels.total()))
      << "depth must have measurements";
}

TEST_F(SourceTest, ARawlogThatIsNoneIsRefused) {
  write_camera_info(folder_.path() / "not_a.rawlog", 1.0);
  const auto file = (folder_.path() / "not_a.rawlog").string();
  EXPECT_FALSE(manager_.load("/source", "rawlog_source", {{"path", file}}));
  EXPECT_TRUE(log_.wait(file)) << log_.text();
}

}  // namespace
}  // namespace extperfc::ros_test
