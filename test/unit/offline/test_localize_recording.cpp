// MRPT's own recordings (package mrpt-common) through the localizer.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "extperfc/base/math.hpp"
#include "extperfc/localize/localizer.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/offline/recording.hpp"

#include "mapping/map_renderer.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::offline {
namespace {

namespace fs = std::filesystem;
using localize::Localizer;
using sources::ScanRecord;
constexpr char kSkip[] = "package mrpt-common is not installed";

fs::path dataset(const std::string& name) {
  return fs::path("/usr/share/mrpt/datasets") / name;
}

/// Scans with odometry, and the poses of the base in the map at which they were taken.
struct Drive {
  std::vector<ScanRecord> records;
  std::vector<Pose2> poses;
};

std::vector<ScanRecord> read_all(const fs::path& file) {
  std::vector<ScanRecord> records;
  const auto log = open_recording(file);
  EXPECT_TRUE(log) << log.error().message;
  while (log) {
    auto record = (*log)->next();
    EXPECT_TRUE(record) << record.error().message;
    if (!record || !*record) break;
    EXPECT_TRUE((*record)->odom_T_base);
    records.push_back(**std::move(record));
  }
  return records;
}

/// A map from every `step`-th scan at its known pose.
std::shared_ptr<const OccupancyGrid> draw(const Drive& drive, std::size_t step) {
  constexpr double kResolution_m = 0.05;
  constexpr double kOccupied = 0.25;
  std::vector<mapping::KeyFrame> frames;
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < drive.records.size(); i += step) {
    frames.push_back({i, 0, mapping::scan_points(drive.records[i].scan, {})});
    poses.push_back(drive.poses[i]);
  }
  mapping::MapRenderer renderer(kResolution_m, kOccupied);
  EXPECT_TRUE(renderer.update(frames, poses, std::numeric_limits<std::size_t>::max()));
  return renderer.map();
}

Localizer make_localizer(const std::shared_ptr<const OccupancyGrid>& map, int min_particles,
                         int max_particles) {
  localize::LocalizerParams params;
  params.min_particles = min_particles;
  params.max_particles = max_particles;
  auto localizer = Localizer::make(params, map);
  EXPECT_TRUE(localizer) << localizer.error().message;
  return *std::move(localizer);
}

/// Feeds scans as a robot would: an update after 0.2 m or 0.2 rad, odometry in between.
class Follower {
 public:
  explicit Follower(Localizer& localizer) : localizer_(localizer) {}

  /// The pose of the base in the map.
  Pose2 see(const ScanRecord& record) {
    const auto updated = localizer_.update(record.scan, *record.odom_T_base);
    EXPECT_TRUE(updated) << updated.error().message;
    if (updated && *updated) {
      ++updates_;
      last_odom_ = *record.odom_T_base;
    }
    return compose(localizer_.estimate().pose, between(last_odom_, *record.odom_T_base));
  }
  [[nodiscard]] std::size_t updates() const { return updates_; }

 private:
  Localizer& localizer_;
  Pose2 last_odom_;
  std::size_t updates_{0};
};

double apart_m(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}
double apart_rad(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

struct Errors {
  double mean_m{0};
  double mean_rad{0};
  double worst_m{0};
  std::size_t scored{0};
};

/// Followed from its start, known to 0.3 m and 0.2 rad; scored at the scans that are not in a map of
/// draw(drive, 2).
Errors track(Localizer& localizer, const Drive& drive) {
  constexpr std::size_t kSettled = 5;
  EXPECT_TRUE(localizer.set_pose(drive.poses[0], Eigen::Vector3d(0.09, 0.09, 0.04).asDiagonal()));
  Follower follower(localizer);
  Errors errors;
  for (std::size_t i = 0; i < drive.records.size(); ++i) {
    const Pose2 pose = follower.see(drive.records[i]);
    if (i < kSettled || i % 2 == 0) continue;
    errors.mean_m += apart_m(pose, drive.poses[i]);
    errors.mean_rad += apart_rad(pose, drive.poses[i]);
    errors.worst_m = std::max(errors.worst_m, apart_m(pose, drive.poses[i]));
    ++errors.scored;
  }
  errors.mean_m /= static_cast<double>(errors.scored);
  errors.mean_rad /= static_cast<double>(errors.scored);
  return errors;
}

/// Searched in the whole map from scan `start` on. The number of the update from which on the estimate stays
/// within 0.5 m and 12 degrees, up to update `max_updates`; none when it is elsewhere in the end.
std::optional<std::size_t> updates_until_found(Localizer& localizer, const Drive& drive, std::size_t start,
                                               std::size_t max_updates) {
  localizer.initialize_globally();
  Follower follower(localizer);
  std::optional<std::size_t> found;
  for (std::size_t i = start; i < drive.records.size() && follower.updates() < max_updates; ++i) {
    const Pose2 pose = follower.see(drive.records[i]);
    if (apart_m(pose, drive.poses[i]) > 0.5 || apart_rad(pose, drive.poses[i]) > 12 * kDegree)
      found.reset();
    else if (!found)
      found = follower.updates();
  }
  return found;
}

/// Starts spread over the drive, nine of ten found within `max_updates` updates and not lost again in as many
/// more. Some views are of places that look alike.
void expect_found_everywhere(const Drive& drive, const std::shared_ptr<const OccupancyGrid>& map,
                             std::size_t max_updates) {
  constexpr std::size_t kStarts = 20;
  constexpr std::size_t kMaxLate = 2;
  auto localizer = make_localizer(map, 500, 10000);
  std::string late;
  std::size_t count = 0;
  for (std::size_t k = 0; k < kStarts; ++k) {
    const std::size_t start = (2 * k + 1) * drive.records.size() / (2 * kStarts + 2);
    const auto updates = updates_until_found(localizer, drive, start, 2 * max_updates);
    if (updates.value_or(2 * max_updates + 1) <= max_updates) continue;
    late += " " + std::to_string(start);
    ++count;
  }
  EXPECT_LE(count, kMaxLate) << "late from scans" << late;
}

/// MRPT's simple map as a recording: its own reader makes scans of it, and odometry is the known pose.
Drive read_simple_map(const fs::path& file) {
  mrpt::maps::CSimpleMap map;
  EXPECT_TRUE(map.loadFromFile(file.string()));
  const TemporaryFolder folder;
  const fs::path rawlog = folder.path() / "map.rawlog";
  {
    mrpt::io::CFileGZOutputStream stream(rawlog.string());
    auto archive = mrpt::serialization::archiveFrom(stream);
    mrpt::poses::CPose2D last;
    for (std::size_t i = 0; i < map.size(); ++i) {
      const auto [pose, seen] = map.get(i);
      const mrpt::poses::CPose2D now(pose->getMeanVal());
      mrpt::obs::CActionRobotMovement2D movement;
      movement.computeFromOdometry(now - last, {});
      mrpt::obs::CActionCollection actions;
      actions.insert(movement);
      archive << actions << *seen;
      last = now;
    }
  }
  Drive drive;
  drive.records = read_all(rawlog);
  for (const auto& record : drive.records) drive.poses.push_back(*record.odom_T_base);
  return drive;
}

/// Lines `stamp x y yaw` by stamp [ms].
std::map<long, Pose2> read_truth(const fs::path& file) {
  std::map<long, Pose2> truth;
  std::ifstream in(file);
  double stamp_s = 0;
  for (Pose2 pose; in >> stamp_s >> pose.x >> pose.y >> pose.yaw;) truth[std::lround(1e3 * stamp_s)] = pose;
  return truth;
}

// None of the recording's scans is in the map. MRPT's own test of its filter wants this last pose, to 0.5 m;
// nothing is published of the poses before.
TEST(LocalizeRecording, TheDemonstrationOfMrptInItsMap) {
  const fs::path recording = dataset("localization_demo.rawlog");
  if (!fs::exists(recording)) GTEST_SKIP() << kSkip;
  const Pose2 last{15.89, -10.0, 4.8 * kDegree};
  const auto map = draw(read_simple_map(dataset("localization_demo.simplemap.gz")), 1);
  const auto records = read_all(recording);
  ASSERT_EQ(records.size(), 37U);
  auto searching = make_localizer(map, 500, 10000);
  auto tracking = make_localizer(map, 500, 500);
  const Pose2 start = compose(last, between(*records.back().odom_T_base, *records.front().odom_T_base));
  ASSERT_TRUE(tracking.set_pose(start, Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal()));
  Follower searcher(searching);
  Follower tracker(tracking);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Pose2 found = searcher.see(records[i]);
    const Pose2 followed = tracker.see(records[i]);
    if (i < 8) continue;
    EXPECT_LT(apart_m(found, followed), 0.1) << "scan " << i;
    EXPECT_LT(apart_rad(found, followed), 1 * kDegree) << "scan " << i;
    EXPECT_GT(searching.estimate().fit, 0.9) << "scan " << i;
    if (i + 1 < records.size()) continue;
    for (const Pose2& pose : {found, followed}) {
      EXPECT_LT(apart_m(pose, last), 0.15);
      EXPECT_LT(apart_rad(pose, last), 1.5 * kDegree);
    }
  }
}

// Our mapper's poses are the reference; every second scan draws the map, the others are scored.
TEST(LocalizeRecording, OneLoopOfAFaculty) {
  const fs::path recording = dataset("2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog");
  if (!fs::exists(recording)) GTEST_SKIP() << kSkip;
  auto mapper = mapping::Mapper::make({});
  const auto log = open_recording(recording);
  ASSERT_TRUE(mapper && log);
  Drive drive;
  drive.records = read_all(recording);
  for (const auto& stamped : map_recording(**log, *mapper).trajectory) drive.poses.push_back(stamped.pose);
  ASSERT_EQ(drive.poses.size(), drive.records.size());
  const auto map = draw(drive, 2);
  auto localizer = make_localizer(map, 500, 500);
  const Errors errors = track(localizer, drive);
  EXPECT_EQ(errors.scored, 110U);
  EXPECT_LT(errors.mean_m, 0.05);
  EXPECT_LT(errors.mean_rad, 1 * kDegree);
  expect_found_everywhere(drive, map, 10);
}

// Simulated by MRPT, with the true pose of each scan. Once the recording pauses for a second and continues
// more than a metre away.
TEST(LocalizeRecording, ASimulationWithKnownPoses) {
  const fs::path recording = dataset("graphslam-engine-demos/action_observations_map/simul.rawlog");
  const fs::path truth_file = recording.string() + ".GT.txt";
  if (!fs::exists(truth_file)) GTEST_SKIP() << kSkip;
  const auto truth = read_truth(truth_file);
  Drive drive;
  for (auto& record : read_all(recording)) {
    const auto known = truth.find(std::lround(1e3 * record.scan.stamp_s));
    if (known == truth.end()) continue;
    drive.poses.push_back(known->second);
    drive.records.push_back(std::move(record));
  }
  ASSERT_GT(drive.records.size(), 1700U);
  auto localizer = make_localizer(draw(drive, 2), 500, 500);
  const Errors errors = track(localizer, drive);
  EXPECT_LT(errors.mean_m, 0.08);
  EXPECT_LT(errors.mean_rad, 0.5 * kDegree);
}

}  // namespace
}  // namespace extperfc::offline
