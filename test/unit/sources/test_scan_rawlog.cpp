#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/sources/scan_log.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

namespace fs = std::filesystem;
using mrpt::obs::CObservation2DRangeScan;

constexpr char kExample[] =
    "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";

/// Five rays over half a revolution: 1 m, 2 m, ..., the last one without echo.
CObservation2DRangeScan::Ptr make_scan(double stamp_s, const std::string& label = "laser") {
  auto scan = CObservation2DRangeScan::Create();
  scan->timestamp = mrpt::Clock::fromDouble(stamp_s);
  scan->sensorLabel = label;
  scan->aperture = static_cast<float>(M_PI);
  scan->maxRange = 10;
  scan->rightToLeft = true;
  scan->sensorPose = mrpt::poses::CPose3D(0.2, 0.1, 0.5, 0.3, 0, 0);
  scan->resizeScan(5);
  for (std::size_t i = 0; i < 5; ++i) {
    scan->setScanRange(i, i < 4 ? static_cast<float>(i + 1) : 10.0F);
    scan->setScanRangeValidity(i, i < 4);
  }
  return scan;
}

mrpt::obs::CObservationOdometry::Ptr make_odometry(double stamp_s, double x) {
  auto odometry = mrpt::obs::CObservationOdometry::Create();
  odometry->timestamp = mrpt::Clock::fromDouble(stamp_s);
  odometry->odometry = mrpt::poses::CPose2D(x, 0, 0);
  return odometry;
}

mrpt::obs::CActionCollection::Ptr make_action(double x, double phi) {
  mrpt::obs::CActionRobotMovement2D movement;
  movement.computeFromOdometry(mrpt::poses::CPose2D(x, 0, phi), {});
  auto actions = mrpt::obs::CActionCollection::Create();
  actions->insert(movement);
  return actions;
}

mrpt::obs::CSensoryFrame::Ptr make_moment(const CObservation2DRangeScan::Ptr& scan) {
  auto moment = mrpt::obs::CSensoryFrame::Create();
  moment->insert(scan);
  return moment;
}

template <typename... Objects>
fs::path write_rawlog(const fs::path& file, const Objects&... objects) {
  mrpt::io::CFileGZOutputStream stream(file.string());
  auto archive = mrpt::serialization::archiveFrom(stream);
  (archive.WriteObject(objects.get()), ...);
  return file;
}

std::vector<ScanRecord> read_all(ScanLog& log) {
  std::vector<ScanRecord> records;
  while (true) {
    auto record = log.next();
    EXPECT_TRUE(record) << record.error().message;
    if (!record || !*record) return records;
    records.push_back(**std::move(record));
  }
}

TEST(ScanRawlog, ObservationsWithOdometryOfTheirOwn) {
  const TemporaryFolder folder;
  const auto file = write_rawlog(folder.path() / "a.rawlog", make_odometry(1.0, 0), make_scan(1.5),
                                 make_odometry(2.0, 4), make_scan(1.7, "other"), make_scan(1.8));
  const auto log = open_scan_rawlog(file);
  ASSERT_TRUE(log) << log.error().message;
  const auto records = read_all(**log);
  ASSERT_EQ(records.size(), 2U) << "only the first scanner counts";
  const auto& scan = records[0].scan;
  EXPECT_NEAR(scan.stamp_s, 1.5, 1e-6);
  EXPECT_NEAR(scan.angle_min, -M_PI / 2, 1e-6);
  EXPECT_NEAR(scan.angle_increment, M_PI / 4, 1e-6);
  EXPECT_NEAR(scan.base_T_sensor.x, 0.2, 1e-9);
  EXPECT_NEAR(scan.base_T_sensor.yaw, 0.3, 1e-9);
  EXPECT_EQ(count_returns(scan), 4U);
  EXPECT_FLOAT_EQ(scan.ranges[2], 3.0F);
  EXPECT_TRUE(std::isinf(scan.ranges[4]));
  ASSERT_TRUE(records[0].odom_T_base && records[1].odom_T_base);
  EXPECT_NEAR(records[0].odom_T_base->x, 2, 1e-5);
  EXPECT_NEAR(records[1].odom_T_base->x, 3.2, 1e-5);
  EXPECT_NEAR((*log)->progress(), 1.0, 1e-9);
}

TEST(ScanRawlog, TheScannerCanBeChosen) {
  const TemporaryFolder folder;
  const auto file =
      write_rawlog(folder.path() / "a.rawlog", make_scan(1), make_scan(2, "other"), make_scan(3));
  ScanLogOptions options;
  options.sensor_label = "other";
  options.base_T_sensor = Pose2{1, 2, 3};
  options.max_range_m = 3.5;
  const auto log = open_scan_rawlog(file, options);
  ASSERT_TRUE(log) << log.error().message;
  const auto records = read_all(**log);
  ASSERT_EQ(records.size(), 1U);
  EXPECT_NEAR(records[0].scan.stamp_s, 2, 1e-6);
  EXPECT_EQ(records[0].scan.base_T_sensor.y, 2);
  EXPECT_EQ(count_returns(records[0].scan), 3U);
}

TEST(ScanRawlog, ActionsAddUp) {
  const TemporaryFolder folder;
  const auto file =
      write_rawlog(folder.path() / "a.rawlog", make_moment(make_scan(1)), make_action(1, M_PI / 2),
                   make_moment(make_scan(2)), make_action(2, 0), make_moment(make_scan(3)));
  const auto log = open_scan_rawlog(file);
  ASSERT_TRUE(log) << log.error().message;
  const auto records = read_all(**log);
  ASSERT_EQ(records.size(), 3U);
  EXPECT_NEAR(records[0].odom_T_base->x, 0, 1e-9) << "before the first action";
  EXPECT_NEAR(records[1].odom_T_base->x, 1, 1e-9);
  EXPECT_NEAR(records[2].odom_T_base->x, 1, 1e-9);
  EXPECT_NEAR(records[2].odom_T_base->y, 2, 1e-9);
  EXPECT_NEAR(records[2].odom_T_base->yaw, M_PI / 2, 1e-9);
}

TEST(ScanRawlog, ScannersThatHangUpsideDown) {
  const TemporaryFolder folder;
  const auto hanging = make_scan(1);
  hanging->sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0, M_PI);  // roll
  const auto left_to_right = make_scan(2);
  left_to_right->rightToLeft = false;
  const auto log = open_scan_rawlog(write_rawlog(folder.path() / "a.rawlog", hanging, left_to_right));
  ASSERT_TRUE(log) << log.error().message;
  for (const auto& record : read_all(**log)) {
    EXPECT_NEAR(record.scan.angle_min, M_PI / 2, 1e-6);
    EXPECT_NEAR(record.scan.angle_increment, -M_PI / 4, 1e-6);
  }
}

TEST(ScanRawlog, TiltedAndEmptyScansAreLeftOut) {
  const TemporaryFolder folder;
  const auto tilted = make_scan(1);
  tilted->sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0.5, 0);  // pitch
  const auto empty = make_scan(2);
  empty->resizeScan(0);
  const auto log = open_scan_rawlog(write_rawlog(folder.path() / "a.rawlog", tilted, empty, make_scan(3)));
  ASSERT_TRUE(log) << log.error().message;
  const auto records = read_all(**log);
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].index, 2U);
  EXPECT_EQ((*log)->damaged(), 2U);
  ASSERT_EQ((*log)->complaints().size(), 2U);
  EXPECT_NE((*log)->complaints()[0].find("tilted"), std::string::npos);
}

TEST(ScanRawlog, DamagedFilesGiveWhatCameBefore) {
  const TemporaryFolder folder;
  const auto file = write_rawlog(folder.path() / "a.rawlog", make_odometry(1, 0), make_scan(1),
                                 make_odometry(2, 1), make_scan(1.5));
  std::ifstream in(file, std::ios::binary);
  std::string packed{std::istreambuf_iterator<char>(in), {}};
  const auto broken = folder.write("b.rawlog", packed.substr(0, packed.size() - 30));
  const auto log = open_scan_rawlog(broken);
  if (!log) {
    EXPECT_EQ(log.error().code, ErrorCode::kCorrupt);
    return;
  }
  auto record = (*log)->next();
  while (record && *record) record = (*log)->next();
  ASSERT_FALSE(record);
  EXPECT_NE(record.error().message.find("damaged or breaks off"), std::string::npos);
  EXPECT_FALSE((*log)->next());
}

TEST(ScanRawlog, OtherFilesAreRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(open_scan_rawlog(folder.path() / "none.rawlog").error().code, ErrorCode::kNotFound);
  for (const auto& content : {std::string("FLASER 180 1 2 3\n"),
                              std::string("\x98"
                                          "CNoSuchClassOfMrptAtAll!"),
                              std::string("\x1f\x8b no gzip")}) {
    const auto log = open_scan_rawlog(folder.write("b.rawlog", content));
    if (log) {
      const auto record = (*log)->next();
      EXPECT_TRUE(!record || !*record);
    } else {
      EXPECT_EQ(log.error().code, ErrorCode::kCorrupt);
      EXPECT_EQ(log.error().message.find('\n'), std::string::npos);
    }
  }
}

TEST(ScanRawlog, MrptsOwnRecording) {
  if (!fs::exists(kExample)) GTEST_SKIP() << "package mrpt-common is not installed";
  const auto log = open_scan_rawlog(kExample);
  ASSERT_TRUE(log) << log.error().message;
  const auto records = read_all(**log);
  EXPECT_EQ(records.size(), 225U);
  double distance_m = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    ASSERT_TRUE(records[i].odom_T_base) << i;
    EXPECT_EQ(records[i].scan.ranges.size(), 361U);
    EXPECT_GT(count_returns(records[i].scan), 100U);
    if (i > 0) {
      const Pose2 step = between(*records[i - 1].odom_T_base, *records[i].odom_T_base);
      distance_m += std::hypot(step.x, step.y);
    }
  }
  EXPECT_NEAR(distance_m, 76.4, 0.2);
}

}  // namespace
}  // namespace extperfc::sources
