#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/offline/map_recording.hpp"

namespace extperfc::offline {
namespace {

using mapping::Mapper;
using sources::ScanRecord;

/// A robot that drives along a square room's wall; scan `bad` is one that no mapper takes.
class RoomLog : public sources::ScanLog {
 public:
  explicit RoomLog(std::size_t scans) : scans_(scans) {}

  Result<std::optional<ScanRecord>> next() override {
    if (next_ == breaks_at) return fail(ErrorCode::kCorrupt, "it breaks off");
    if (next_ == scans_) return std::optional<ScanRecord>();
    return std::optional(record(next_++));
  }
  [[nodiscard]] double progress() const override {
    return static_cast<double>(next_) / static_cast<double>(scans_);
  }
  [[nodiscard]] std::size_t damaged() const override { return 2; }
  [[nodiscard]] const std::vector<std::string>& complaints() const override { return complaints_; }

  std::size_t bad{std::numeric_limits<std::size_t>::max()};
  std::size_t breaks_at{std::numeric_limits<std::size_t>::max()};

 private:
  [[nodiscard]] ScanRecord record(std::size_t i) const {
    ScanRecord record;
    record.index = i;
    const double x = 0.1 * static_cast<double>(i);
    record.odom_T_base = Pose2{x, 0, 0};
    auto& scan = record.scan;
    scan.stamp_s = 10 + static_cast<double>(i);
    scan.angle_min = -M_PI;
    scan.angle_increment = M_PI / 90;
    scan.range_max = 20;
    constexpr std::size_t kRays = 180;
    for (std::size_t ray = 0; ray < kRays; ++ray) {
      const double angle = scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
      const double dx = std::cos(angle) > 0 ? (6 - x) / std::cos(angle) : (-5 - x) / std::cos(angle);
      const double dy = std::sin(angle) > 0 ? 4 / std::sin(angle) : -3 / std::sin(angle);
      scan.ranges.push_back(static_cast<float>(std::min(dx, dy)));
    }
    if (i == bad) scan.angle_increment = 0;
    return record;
  }

  std::size_t scans_;
  std::size_t next_{0};
  std::vector<std::string> complaints_{"line 7: damaged"};
};

Mapper make_mapper() {
  mapping::MapperParams params;
  params.particles = 3;
  auto mapper = Mapper::make(params);
  EXPECT_TRUE(mapper);
  return *std::move(mapper);
}

TEST(MapRecording, EveryScanGetsAPose) {
  RoomLog log(30);
  auto mapper = make_mapper();
  const auto result = map_recording(log, mapper);
  EXPECT_EQ(result.scans, 30U);
  EXPECT_EQ(result.refused, 0U);
  EXPECT_EQ(result.damaged, 2U);
  EXPECT_FALSE(result.interrupted);
  EXPECT_EQ(result.broken, "");
  EXPECT_DOUBLE_EQ(result.recorded_s, 29);
  EXPECT_NEAR(result.odometry_m, 2.9, 1e-9);
  ASSERT_EQ(result.trajectory.size(), 30U);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(result.scan_index[i], i);
    EXPECT_DOUBLE_EQ(result.trajectory[i].stamp_s, 10 + static_cast<double>(i));
    EXPECT_NEAR(result.trajectory[i].pose.x - result.trajectory[0].pose.x, 0.1 * static_cast<double>(i),
                0.05);
  }
  EXPECT_GT(result.cpu_ms.max, 0);
  EXPECT_LE(result.cpu_ms.p50, result.cpu_ms.p99);
  EXPECT_LE(result.cpu_ms.p99, result.cpu_ms.max);
}

TEST(MapRecording, RefusedScansFollowOdometry) {
  RoomLog log(10);
  log.bad = 4;
  auto mapper = make_mapper();
  const auto result = map_recording(log, mapper);
  EXPECT_EQ(result.refused, 1U);
  ASSERT_EQ(result.trajectory.size(), 10U);
  const Pose2 step = between(result.trajectory[3].pose, result.trajectory[4].pose);
  EXPECT_NEAR(step.x, 0.1, 1e-9);
  EXPECT_NEAR(step.y, 0, 1e-9);
  ASSERT_EQ(result.complaints.size(), 2U);
  EXPECT_EQ(result.complaints[0], "line 7: damaged");
  EXPECT_NE(result.complaints[1].find("scan 4: "), std::string::npos);
}

TEST(MapRecording, EndsWhenAskedTo) {
  RoomLog log(30);
  auto mapper = make_mapper();
  MappingOptions options;
  double fraction = -1;
  options.should_continue = [&](const MappingProgress& progress) {
    EXPECT_GT(progress.fraction, fraction);
    fraction = progress.fraction;
    return progress.scans < 7;
  };
  const auto result = map_recording(log, mapper, options);
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.trajectory.size(), 7U);
}

TEST(MapRecording, LimitsAndBrokenRecordings) {
  RoomLog log(30);
  auto mapper = make_mapper();
  MappingOptions options;
  options.max_scans = 5;
  const auto first = map_recording(log, mapper, options);
  EXPECT_EQ(first.scans, 5U);
  EXPECT_FALSE(first.interrupted);
  log.breaks_at = 12;
  const auto rest = map_recording(log, mapper);  // continues with the same mapper
  EXPECT_EQ(rest.broken, "it breaks off");
  EXPECT_EQ(rest.scans, 7U);
  ASSERT_EQ(rest.trajectory.size(), 7U);
  EXPECT_DOUBLE_EQ(rest.trajectory[0].stamp_s, 15);
  EXPECT_NEAR(rest.trajectory[6].pose.x - rest.trajectory[0].pose.x, 0.6, 0.05);
}

TEST(MapRecording, OdometryCanBeLeftOut) {
  RoomLog log(20);
  auto mapper = make_mapper();
  MappingOptions options;
  options.use_odometry = false;
  const auto result = map_recording(log, mapper, options);
  EXPECT_EQ(result.without_odometry, 20U);
  EXPECT_EQ(result.odometry_m, 0);
  EXPECT_NEAR(result.trajectory[19].pose.x - result.trajectory[0].pose.x, 1.9, 0.1) << "by the walls alone";
}

TEST(MapRecording, AnEmptyRecording) {
  RoomLog log(0);
  auto mapper = make_mapper();
  const auto result = map_recording(log, mapper);
  EXPECT_EQ(result.scans, 0U);
  EXPECT_TRUE(result.trajectory.empty());
  EXPECT_GT(peak_memory_mb(), 1);
}

}  // namespace
}  // namespace extperfc::offline
