#include <cstdint>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "extperfc/sources/recording.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

namespace fs = std::filesystem;

void write_color(const fs::path& file, int blue, cv::Size size = {16, 12}) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(size, CV_8UC3, cv::Scalar(blue, 0, 200))));
}

void write_depth(const fs::path& file, int value, cv::Size size = {16, 12}) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(size, CV_16UC1, cv::Scalar(value))));
}

void expect_error(const Error& error, ErrorCode code, const std::string& part) {
  EXPECT_EQ(error.code, code) << error.message;
  EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
}

TEST(PairFolder, EqualNamesInNaturalOrder) {
  const TemporaryFolder folder;
  for (const int i : {10, 9, 100}) {
    write_color(folder.path() / "rgb" / (std::to_string(i) + ".jpg"), i);
    write_depth(folder.path() / "depth" / (std::to_string(i) + ".png"), 10 * i);
  }
  folder.write("rgb/notes.txt", "not an image");
  const auto recording = open_pair_folder(folder.path());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ((*recording)->size(), 3U);
  EXPECT_FALSE((*recording)->camera());
  const auto last = (*recording)->frame(2);
  ASSERT_TRUE(last) << last.error().message;
  EXPECT_EQ(last->label, "100.jpg");
  EXPECT_EQ(last->depth.at<std::uint16_t>(5, 5), 1000);
  EXPECT_EQ(last->color.type(), CV_8UC3);
  EXPECT_NEAR(last->stamp_s, 2.0 / 30.0, 1e-12);
  const auto again = (*recording)->frame(0);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->depth.at<std::uint16_t>(0, 0), 90);
}

TEST(PairFolder, AssociationsGiveFilesAndStamps) {
  const TemporaryFolder folder;
  write_color(folder.path() / "rgb/a.png", 1);
  write_depth(folder.path() / "depth/z.png", 5000);
  folder.write("associations.txt", "# comment\n\n1305031102.175304 rgb/a.png 1305031102.16 depth/z.png\r\n");
  const auto recording = open_pair_folder(folder.path(), 5000.0);  // TUM's own scale
  ASSERT_TRUE(recording) << recording.error().message;
  const auto frame = (*recording)->frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_DOUBLE_EQ(frame->stamp_s, 1305031102.175304);
  EXPECT_EQ(frame->depth.at<std::uint16_t>(0, 0), 1000);
}

TEST(PairFolder, AssociationErrorsNameTheLine) {
  const TemporaryFolder folder;
  folder.write("associations.txt", "# comment\n1.0 rgb/a.png\n");
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kCorrupt, "line 2");
  folder.write("associations.txt", "1.0 rgb/a.png 1.0 depth/a.png\n");
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kNotFound, "rgb/a.png");
}

TEST(PairFolder, ColourAloneHasEmptyDepth) {
  const TemporaryFolder folder;
  write_color(folder.path() / "one.PNG", 1);
  const auto recording = open_pair_folder(folder.path());
  ASSERT_TRUE(recording) << recording.error().message;
  const auto frame = (*recording)->frame(0);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->depth.empty());
  EXPECT_EQ(frame->color.cols, 16);
}

TEST(PairFolder, CameraFileIsReadAndChecked) {
  const TemporaryFolder folder;
  write_color(folder.path() / "color/1.png", 1);
  write_depth(folder.path() / "depth/1.png", 1);
  const std::string rest =
      "image_height: 12\ncamera_matrix: {rows: 3, cols: 3, data: [9, 0, 8, 0, 9, 6, 0, 0, 1]}\n";
  folder.write("camera_info.yaml", "image_width: 16\n" + rest);
  const auto recording = open_pair_folder(folder.path());
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_TRUE((*recording)->camera());
  EXPECT_DOUBLE_EQ((*recording)->camera()->fx, 9.0);
  folder.write("camera_info.yaml", "image_width: 32\n" + rest);
  expect_error((*open_pair_folder(folder.path()))->frame(0).error(), ErrorCode::kInvalidArgument, "32 x 12");
  folder.write("camera_info.yaml", "nonsense");
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kCorrupt, "camera_info.yaml");
}

TEST(PairFolder, FoldersThatCannotBePlayed) {
  const TemporaryFolder folder;
  expect_error(open_pair_folder(folder.path() / "none").error(), ErrorCode::kNotFound, "no such folder");
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kNotFound, "associations.txt");
  expect_error(open_pair_folder(folder.path(), 0.0).error(), ErrorCode::kInvalidArgument, "depth scale");
  write_color(folder.path() / "rgb/1.png", 1);
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kNotFound, "no depth/");
  write_depth(folder.path() / "depth/1.png", 1);
  write_color(folder.path() / "rgb/7.png", 1);
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kNotFound, "7.png");
  fs::remove(folder.path() / "rgb/7.png");
  write_depth(folder.path() / "depth/8.png", 1);
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kNotFound, "8.png");
  fs::remove(folder.path() / "depth/8.png");
  write_color(folder.path() / "rgb/1.jpg", 1);
  expect_error(open_pair_folder(folder.path()).error(), ErrorCode::kInvalidArgument, "1.jpg");
}

TEST(PairFolder, FramesThatCannotBeRead) {
  const TemporaryFolder folder;
  for (const char* name : {"1.png", "2.png", "3.png", "4.png"}) {
    write_color(folder.path() / "rgb" / name, 1);
    write_depth(folder.path() / "depth" / name, 1);
  }
  folder.write("rgb/1.png", "damaged");
  folder.write("depth/2.png", "");
  write_depth(folder.path() / "depth/3.png", 1, {8, 6});
  write_color(folder.path() / "depth/4.png", 1);  // 8-bit colour is no depth
  const auto recording = open_pair_folder(folder.path());
  ASSERT_TRUE(recording) << recording.error().message;
  expect_error((*recording)->frame(0).error(), ErrorCode::kCorrupt, "rgb/1.png");
  expect_error((*recording)->frame(1).error(), ErrorCode::kCorrupt, "depth/2.png");
  expect_error((*recording)->frame(2).error(), ErrorCode::kInvalidArgument, "8 x 6");
  expect_error((*recording)->frame(3).error(), ErrorCode::kCorrupt, "CV_8UC3");
  expect_error((*recording)->frame(4).error(), ErrorCode::kInvalidArgument, "frame 4");
}

TEST(PairFolder, RealKinectImages) {
  const fs::path folder = fs::path(EXTPERFC_SOURCE_DIR) / "../shared/data/rgbd/dining_room";
  if (!fs::exists(folder)) GTEST_SKIP() << "the recording of a dining room is not on this machine";
  const auto recording = open_pair_folder(folder);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ((*recording)->size(), 5U);
  for (std::size_t i = 0; i < (*recording)->size(); ++i) {
    const auto frame = (*recording)->frame(i);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->label, std::to_string(i + 1) + ".png");
    EXPECT_EQ(frame->color.size(), cv::Size(640, 480));
    EXPECT_EQ(frame->depth.type(), CV_16UC1);
    EXPECT_GT(cv::countNonZero(frame->depth), 640 * 480 / 2);
  }
}

}  // namespace
}  // namespace extperfc::sources
