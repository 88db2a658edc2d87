#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/trajectory.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc {
namespace {

std::string complaint(const TemporaryFolder& folder, const std::string& content) {
  const auto read = read_tum(folder.write("t.tum", content));
  return read ? "" : read.error().message;
}

TEST(Trajectory, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    Trajectory written;
    const int size = rng.integer(0, 200);
    for (int i = 0; i < size; ++i)  // stamps run backwards at will
      written.push_back({rng.uniform(0, 2e9),
                         {rng.uniform(-1000, 1000), rng.uniform(-1000, 1000), rng.uniform(-M_PI, M_PI)}});
    const auto file = folder.path() / "a.tum";
    ASSERT_TRUE(write_tum(written, file));
    const auto read = read_tum(file);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->size(), written.size()) << "trial " << trial;
    for (std::size_t i = 0; i < written.size(); ++i) {
      EXPECT_NEAR((*read)[i].stamp_s, written[i].stamp_s, 1e-6);
      EXPECT_NEAR((*read)[i].pose.x, written[i].pose.x, 1e-8);
      EXPECT_NEAR((*read)[i].pose.y, written[i].pose.y, 1e-8);
      EXPECT_NEAR(wrap_angle((*read)[i].pose.yaw - written[i].pose.yaw), 0, 1e-9);
    }
  }
}

TEST(Trajectory, WritesTheFormatThatOthersRead) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_tum({{12.5, {1, -2, M_PI / 2}}}, folder.path() / "a.tum"));
  std::ifstream in(folder.path() / "a.tum");
  std::string comment;
  std::string line;
  std::getline(in, comment);
  std::getline(in, line);
  EXPECT_EQ(comment, "# stamp x y z qx qy qz qw");
  EXPECT_EQ(line, "12.500000000 1.000000000 -2.000000000 0 0 0 0.707106781187 0.707106781187");
}

TEST(Trajectory, ReadsWhatOthersWrite) {
  const TemporaryFolder folder;
  const auto read = read_tum(folder.write("t.tum",
                                          "# a comment\n\n  1e3 1 2 0.5 0 0 1 0\r\n"
                                          "2.5 -1 +2 0 0 0 -0.7071 -0.7071 extra\n"));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].stamp_s, 1000);
  EXPECT_NEAR(std::abs((*read)[0].pose.yaw), M_PI, 1e-12);
  EXPECT_NEAR((*read)[1].pose.yaw, M_PI / 2, 1e-4);  // q and -q are one rotation
}

TEST(Trajectory, DamageIsNamedByFileAndLine) {
  const TemporaryFolder folder;
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_NE(complaint(folder, good + "2 0 0 0 0 0 1\n").find("t.tum line 2: expected"), std::string::npos);
  EXPECT_NE(complaint(folder, good + "2 0 nan 0 0 0 0 1\n").find("line 2"), std::string::npos);
  EXPECT_NE(complaint(folder, good + good + "2 0 0 0 0 0 0 0\n").find("line 3: the quaternion"),
            std::string::npos);
  EXPECT_NE(complaint(folder, std::string(3000, 'x')).find("line 1"), std::string::npos);
  EXPECT_LT(complaint(folder, std::string(3000, 'x')).size(), 300U);
  EXPECT_EQ(complaint(folder, ""), "");
}

TEST(Trajectory, MissingFilesAndFolders) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_tum(folder.path() / "none.tum").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_tum(folder.path()).error().code, ErrorCode::kNotFound);
  const auto written = write_tum({}, folder.path() / "no" / "such" / "t.tum");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("No such file or directory"), std::string::npos);
}

}  // namespace
}  // namespace extperfc
