#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/sources/scan_log.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(EXTPERFC_TEST_DATA) / "carmen";

/// A FLASER line of `n` rays, each 2 m long.
std::string flaser(std::size_t n, const std::string& behind = "1 2 0.5 1 2 0.5 100.5 host 0.5") {
  std::string line = "FLASER " + std::to_string(n);
  for (std::size_t i = 0; i < n; ++i) line += " 2.0";
  return line + " " + behind + "\n";
}

struct LogContents {
  std::vector<ScanRecord> records;
  std::string error;  // empty: the regular end
  std::size_t damaged{0};
  std::vector<std::string> complaints;
};

LogContents read_all(const fs::path& file, const ScanLogOptions& options = {}) {
  LogContents all;
  auto log = open_carmen_log(file, options);
  if (!log) {
    all.error = log.error().message;
    return all;
  }
  double progress = 0;
  while (true) {
    auto record = (*log)->next();
    EXPECT_GE((*log)->progress(), progress);
    progress = (*log)->progress();
    if (!record) {
      all.error = record.error().message;
      EXPECT_FALSE((*log)->next()) << "an error stays";
      break;
    }
    if (!*record) break;
    all.records.push_back(**std::move(record));
  }
  EXPECT_LE(progress, 1.0);
  all.damaged = (*log)->damaged();
  all.complaints = (*log)->complaints();
  return all;
}

LogContents read_text(const std::string& text, const ScanLogOptions& options = {}) {
  const TemporaryFolder folder;
  return read_all(folder.write("a.clf", text), options);
}

TEST(CarmenLog, ReadsPlainAndPackedAlike) {
  for (const char* name : {"small.clf", "small.clf.gz", "small.clf.bz2"}) {
    SCOPED_TRACE(name);
    const auto all = read_all(kData / name);
    EXPECT_EQ(all.error, "");
    EXPECT_EQ(all.damaged, 0U);
    ASSERT_EQ(all.records.size(), 6U);
    for (std::size_t i = 0; i < 5; ++i) {
      const auto& record = all.records[i];
      EXPECT_EQ(record.index, i);
      ASSERT_TRUE(record.odom_T_base);
      EXPECT_NEAR(record.odom_T_base->x, 0.1 * static_cast<double>(i), 1e-9);
      EXPECT_DOUBLE_EQ(record.scan.base_T_sensor.x, 0.2);  // the PARAM line
      ASSERT_EQ(record.scan.ranges.size(), 180U);
      EXPECT_TRUE(std::isinf(record.scan.ranges[0]));
      EXPECT_FLOAT_EQ(record.scan.ranges[1], 0.6F);
      EXPECT_TRUE(validate(record.scan));
    }
    EXPECT_DOUBLE_EQ(all.records[3].scan.stamp_s, 1000.1);  // runs back: the file's order counts
    EXPECT_DOUBLE_EQ(all.records[5].odom_T_base->yaw, 0.1);
  }
}

TEST(CarmenLog, AnglesFollowFromTheNumberOfRays) {
  const struct {
    std::size_t rays;
    double increment_deg;
  } cases[] = {{180, 1}, {181, 1}, {360, 0.5}, {361, 0.5}, {541, 180.0 / 540}};
  for (const auto& [rays, increment_deg] : cases) {
    const auto all = read_text(flaser(rays));
    ASSERT_EQ(all.records.size(), 1U);
    const auto& scan = all.records[0].scan;
    EXPECT_DOUBLE_EQ(scan.angle_min, -M_PI / 2);
    EXPECT_NEAR(scan.angle_increment, increment_deg * M_PI / 180, 1e-12) << rays;
    EXPECT_EQ(count_returns(scan), rays);
  }
}

TEST(CarmenLog, ReadsRobotLaserLines) {
  // Three rays 90 degrees apart, laser 0.1 m before and 0.05 m left of a robot that looks along +y.
  const auto all = read_text(
      "ROBOTLASER1 0 -1.570796 3.141593 1.570796 20.0 0.01 0 3 1.5 20.0 25.0 1 7.0 "
      "4.95 6.1 1.570796 5 6 1.570796 0.1 0.2 0.3 0.4 0.5 77.25 host 1\n");
  ASSERT_EQ(all.records.size(), 1U) << (all.complaints.empty() ? "" : all.complaints[0]);
  const auto& [scan, odom_T_base, index] = all.records[0];
  EXPECT_DOUBLE_EQ(scan.stamp_s, 77.25);
  EXPECT_DOUBLE_EQ(scan.angle_min, -1.570796);
  EXPECT_DOUBLE_EQ(scan.angle_increment, 1.570796);
  EXPECT_DOUBLE_EQ(scan.range_max, 20);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.5F);
  EXPECT_TRUE(std::isinf(scan.ranges[1]) && std::isinf(scan.ranges[2]));
  EXPECT_NEAR(scan.base_T_sensor.x, 0.1, 1e-6);
  EXPECT_NEAR(scan.base_T_sensor.y, 0.05, 1e-6);
  EXPECT_NEAR(scan.base_T_sensor.yaw, 0, 1e-6);
  EXPECT_DOUBLE_EQ(odom_T_base->y, 6);
}

TEST(CarmenLog, OfTwoKindsTheFirstCounts) {
  const std::string robot = "ROBOTLASER1 0 -1.5 3 1.5 20 0.01 0 3 1 2 3 0 0 0 0 0 0 0 0 0 0 0 0 5 host 1\n";
  EXPECT_EQ(read_text(flaser(180) + robot + flaser(180) + robot).records.size(), 2U);
  const auto other = read_text(robot + flaser(180) + robot + robot);
  ASSERT_EQ(other.records.size(), 3U);
  EXPECT_EQ(other.records[2].scan.ranges.size(), 3U);
}

TEST(CarmenLog, OptionsOverruleTheLog) {
  ScanLogOptions options;
  options.max_range_m = 1.5;
  options.base_T_sensor = Pose2{0.3, -0.1, 3};
  const auto all = read_text("PARAM robot_frontlaser_offset 0.2\n" + flaser(180), options);
  ASSERT_EQ(all.records.size(), 1U);
  EXPECT_EQ(count_returns(all.records[0].scan), 0U);
  EXPECT_TRUE(std::isinf(all.records[0].scan.ranges[7]));
  EXPECT_DOUBLE_EQ(all.records[0].scan.base_T_sensor.yaw, 3);
}

TEST(CarmenLog, DamagedLinesAreLeftOutAndNamed) {
  std::string text = "# comment\nODOM 1 2 3\n\nSYNC\n" + flaser(180);
  text += "FLASER\n";
  text += "FLASER x 1 2\n";
  text += "FLASER 180 1 2 3\n";
  text += "FLASER 1e9 1 2 3\n";
  text += "FLASER -3 1 2 3\n";
  text += flaser(180, "1 2 0.5 1 nan 0.5 100.5 host 0.5");
  text += flaser(180, "1 2 0.5 1 2");
  text += "FLASER 1 2.0 1 2 3 1 2 3 100 host 0\n";
  text += flaser(180);
  const auto all = read_text(text);
  EXPECT_EQ(all.error, "");
  ASSERT_EQ(all.records.size(), 2U);
  EXPECT_EQ(all.records[1].index, 9U) << "damaged scans keep their numbers";
  EXPECT_EQ(all.damaged, 8U);
  ASSERT_EQ(all.complaints.size(), 8U);
  EXPECT_EQ(all.complaints[0], "a.clf line 6: the number of ranges is missing or not a number");
  EXPECT_EQ(all.complaints[2], "a.clf line 8: a range is missing or not a number");
  EXPECT_EQ(all.complaints[3], "a.clf line 9: the number of ranges is not a number from 0 to 100,000");
  EXPECT_EQ(all.complaints[5], "a.clf line 11: the odometry's pose is missing or not a number");
}

TEST(CarmenLog, ComplaintsAreBounded) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += "FLASER broken\n";
  const auto all = read_text(text);
  EXPECT_EQ(all.damaged, 5000U);
  EXPECT_EQ(all.complaints.size(), 10U);
}

TEST(CarmenLog, EndlessLinesTakeLittleMemory) {
  const auto all = read_text("FLASER 180 " + std::string(3 << 20, '1') + "\n" + flaser(180));
  EXPECT_EQ(all.damaged, 1U);
  ASSERT_EQ(all.records.size(), 1U);
}

TEST(CarmenLog, PackedFilesThatBreakOff) {
  const TemporaryFolder folder;
  for (const char* name : {"small.clf.gz", "small.clf.bz2"}) {
    std::ifstream in(kData / name, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    for (const std::size_t keep : {whole.size() / 2, whole.size() - 9}) {
      const auto all = read_all(folder.write(name, whole.substr(0, keep)));
      EXPECT_NE(all.error.find("is damaged or breaks off"), std::string::npos)
          << name << " " << keep << all.error;
    }
    std::string flipped = whole;
    for (std::size_t i = flipped.size() / 3; i < flipped.size() / 3 + 8; ++i) flipped[i] = '\x55';
    const auto all = read_all(folder.write(name, flipped));
    EXPECT_NE(all.error, "") << name;
  }
}

TEST(CarmenLog, OtherFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(open_carmen_log(folder.path() / "none.clf").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(open_carmen_log(folder.path()).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(open_carmen_log(folder.write("b.clf", std::string("FLASER\0 2", 9))).error().code,
            ErrorCode::kCorrupt);
  EXPECT_TRUE(read_text("").records.empty());
  EXPECT_EQ(read_text("no scan\nin here\n").error, "");
  EXPECT_EQ(read_text(flaser(180).substr(0, 700)).damaged, 1U);  // no line's end
}

}  // namespace
}  // namespace extperfc::sources
