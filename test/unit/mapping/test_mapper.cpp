// The mapper as its users see it.
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <malloc.h>

#include "extperfc/mapping/mapper.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/mapping/mapper_drive.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kRoomErrorM = 0.06;

LaserScan without_returns(LaserScan scan, float value = std::numeric_limits<float>::infinity()) {
  std::fill(scan.ranges.begin(), scan.ranges.end(), value);
  return scan;
}

bool same_bits(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

TEST(Mapper, MapsARoom) {
  const auto drive = record_room(1);
  Mapper mapper = make_mapper();
  std::size_t key_frames = 0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto update = mapper.add(drive.scans[i], drive.odometry[i]).value();
    EXPECT_TRUE(update.matched) << i;
    EXPECT_NE(update.status, ScanStatus::kUnusable) << i;
    if (update.status == ScanStatus::kKeyFrame) ++key_frames;
    EXPECT_TRUE(same_bits(update.pose, mapper.pose()));
    ASSERT_LT(drive.error_m(update.pose, i), kRoomErrorM) << i;
  }
  const auto statistics = mapper.statistics();
  EXPECT_EQ(statistics.scans, drive.scans.size());
  EXPECT_EQ(statistics.key_frames, key_frames);
  EXPECT_EQ(statistics.unusable_scans, 0U);
  EXPECT_NEAR(statistics.path_m, 15.6, 1.0);
  const auto map = mapper.map();
  EXPECT_TRUE(mapper.settled());
  EXPECT_EQ(map->resolution_m, 0.05);
  // The start stands at (-3, -1.5) of the room, yaw 0: its left wall is 1 m behind, the lower one 1.5 m to
  // the right.
  const auto at = [&](double x, double y) {
    const auto cell = map->cell_of(x, y);
    return cell ? map->at(cell->column, cell->row) : OccupancyGrid::kUnknown;
  };
  EXPECT_EQ(at(0, 0), OccupancyGrid::kFree);
  EXPECT_EQ(at(4, 1.5), OccupancyGrid::kFree);
  EXPECT_EQ(at(-1.5, 0), OccupancyGrid::kUnknown);
  EXPECT_EQ(at(4, -2), OccupancyGrid::kUnknown);
  std::size_t wall = 0;
  for (double x = -0.9; x < 1.4; x += 0.05)
    if (at(x, -1.5) == OccupancyGrid::kOccupied || at(x, -1.45) == OccupancyGrid::kOccupied ||
        at(x, -1.55) == OccupancyGrid::kOccupied)
      ++wall;
  EXPECT_GE(wall, 44U) << "of 46 cells along the wall";
}

TEST(Mapper, SameSeedSameTrajectory) {
  const auto drive = record_room(2);
  Mapper first = make_mapper();
  Mapper second = make_mapper();
  add_scans(first, drive, 0, drive.scans.size());
  add_scans(second, drive, 0, drive.scans.size());
  first.finish();
  second.finish();
  const auto a = first.trajectory();
  const auto b = second.trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(same_bits(a[i].pose, b[i].pose)) << i;
  EXPECT_EQ(first.map()->cells, second.map()->cells);
}

TEST(Mapper, AskingForTheMapChangesNothing) {
  const auto drive = record_room(3);
  Mapper asked = make_mapper();
  Mapper left_alone = make_mapper();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    (void)asked.add(drive.scans[i], drive.odometry[i]).value();
    (void)left_alone.add(drive.scans[i], drive.odometry[i]).value();
    const auto version = asked.map_version();
    const auto map = asked.map();
    if (asked.map_version() == version) {
      EXPECT_EQ(asked.map()->cells, map->cells);
    }
  }
  EXPECT_TRUE(same_bits(asked.pose(), left_alone.pose()));
}

TEST(Mapper, TrajectoryHasEveryScan) {
  const auto drive = record_room(4);
  Mapper mapper = make_mapper();
  EXPECT_TRUE(mapper.trajectory().empty());
  add_scans(mapper, drive, 0, drive.scans.size());
  const auto trajectory = mapper.trajectory();
  ASSERT_EQ(trajectory.size(), drive.scans.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    EXPECT_EQ(trajectory[i].stamp_s, drive.scans[i].stamp_s);
    ASSERT_LT(drive.error_m(trajectory[i].pose, i), kRoomErrorM) << i;
  }
}

TEST(Mapper, EmptyScansBeforeTheFirstKeyFrame) {
  const auto drive = record_room(5);
  Mapper mapper = make_mapper();
  constexpr std::size_t kBlind = 4;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto scan = i < kBlind ? without_returns(drive.scans[i]) : drive.scans[i];
    const auto update = mapper.add(scan, drive.odometry[i]).value();
    if (i < kBlind) {
      EXPECT_EQ(update.status, ScanStatus::kUnusable);
      EXPECT_FALSE(update.matched);
    }
  }
  const auto trajectory = mapper.trajectory();
  ASSERT_EQ(trajectory.size(), drive.scans.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i)
    ASSERT_LT(drive.error_m(trajectory[i].pose, i), kRoomErrorM + 0.05) << i;
  EXPECT_EQ(mapper.statistics().unusable_scans, kBlind);
}

TEST(Mapper, ScansOfOtherSizesAndDamagedOnesInBetween) {
  const auto drive = record_room(6);
  Mapper mapper = make_mapper();
  Rng rng(1);
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    LaserScan scan = drive.scans[i];
    if (i % 9 == 2) scan.ranges.resize(181);  // half a turn
    if (i % 9 == 4) scan = without_returns(scan, std::numeric_limits<float>::quiet_NaN());
    if (i % 9 == 5) scan.ranges.resize(1);
    if (i % 9 == 7)
      for (float& range : scan.ranges)
        if (rng.chance(0.3)) range = rng.chance(0.5) ? std::numeric_limits<float>::quiet_NaN() : -1.0F;
    const auto update = mapper.add(scan, drive.odometry[i]);
    ASSERT_TRUE(update) << i;
    EXPECT_EQ(update->status == ScanStatus::kUnusable, i % 9 == 4 || i % 9 == 5) << i;
    ASSERT_LT(drive.error_m(update->pose, i), kRoomErrorM + 0.03) << i;
  }
}

TEST(Mapper, TimeMayRunBackwards) {
  const auto drive = record_room(7);
  MapperParams params;
  params.temporal_update_s = 0.35;
  Mapper forward = make_mapper(params);
  Mapper backward = make_mapper(params);
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    LaserScan scan = drive.scans[i];
    (void)forward.add(scan, drive.odometry[i]).value();
    scan.stamp_s = -scan.stamp_s;
    (void)backward.add(scan, drive.odometry[i]).value();
  }
  EXPECT_TRUE(same_bits(forward.pose(), backward.pose()));
  EXPECT_EQ(forward.statistics().key_frames, backward.statistics().key_frames);
  EXPECT_GE(forward.statistics().key_frames, drive.scans.size() / 4) << "one every 0.35 s";
}

TEST(Mapper, RefusesWhatCannotBeAndGoesOn) {
  const auto drive = record_room(8);
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, 20);
  const Pose2 before = mapper.pose();
  LaserScan wrong = drive.scans[20];
  wrong.angle_increment = 0;
  EXPECT_FALSE(mapper.add(wrong, drive.odometry[20]));
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(mapper.add(drive.scans[20], Pose2{value, 0, 0}));
    EXPECT_FALSE(mapper.add(drive.scans[20], Pose2{0, value, 0}));
    EXPECT_FALSE(mapper.add(drive.scans[20], Pose2{0, 0, value}));
  }
  EXPECT_TRUE(same_bits(mapper.pose(), before));
  EXPECT_EQ(mapper.statistics().scans, 20U);
  add_scans(mapper, drive, 20, 30);
  EXPECT_LT(drive.error_m(mapper.pose(), 29), kRoomErrorM);
}

TEST(Mapper, JumpOfOdometryLeavesTheMapAlone) {
  const auto drive = record_room(9);
  Mapper mapper = make_mapper();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    Pose2 odometry = drive.odometry[i];
    if (i >= 40) odometry = compose({1500, -2000, 1}, odometry);
    (void)mapper.add(drive.scans[i], odometry).value();
  }
  EXPECT_LT(drive.error_m(mapper.pose(), drive.scans.size() - 1), kRoomErrorM);
  EXPECT_GE(mapper.statistics().odometry_contradictions, 1U);
  ASSERT_LT(drive.error_m(mapper.pose(), drive.scans.size() - 1), 100.0) << "no map of kilometres, please";
  EXPECT_LT(mapper.map()->cells.size(), 1000U * 1000U);
}

TEST(Mapper, ValidateNamesEachParameter) {
  EXPECT_TRUE(validate(MapperParams{}));
  struct Case {
    const char* name;
    std::function<void(MapperParams&, double)> set;
    double low;
    double high;
  };
  const std::vector<Case> cases = {
      {"delta", [](auto& p, double v) { p.resolution_m = v; }, 0.005, 2},
      {"maxRange", [](auto& p, double v) { p.max_range_m = v; }, -1, 1e9},
      {"maxUrange", [](auto& p, double v) { p.max_usable_range_m = v; }, -1, 1e9},
      {"linearUpdate", [](auto& p, double v) { p.linear_update_m = v; }, 0, 6},
      {"angularUpdate", [](auto& p, double v) { p.angular_update_rad = v; }, 0, 4},
      {"resampleThreshold", [](auto& p, double v) { p.resample_threshold = v; }, -0.1, 1.1},
      {"minimumScore", [](auto& p, double v) { p.minimum_score = v; }, -0.1, 1.1},
      {"srr", [](auto& p, double v) { p.srr = v; }, -0.1, 11},
      {"srt", [](auto& p, double v) { p.srt = v; }, -0.1, 11},
      {"str", [](auto& p, double v) { p.str = v; }, -0.1, 11},
      {"stt", [](auto& p, double v) { p.stt = v; }, -0.1, 11},
      {"occ_thresh", [](auto& p, double v) { p.occupied_threshold = v; }, 0, 1},
      {"temporalUpdate", [](auto& p, double v) { p.temporal_update_s = v; }, -1e9, 1e9},
  };
  for (const Case& c : cases)
    for (const double value : {c.low, c.high, std::numeric_limits<double>::quiet_NaN()}) {
      SCOPED_TRACE(c.name + std::string(" ") + std::to_string(value));
      MapperParams params;
      c.set(params, value);
      const auto valid = validate(params);
      ASSERT_FALSE(valid);
      EXPECT_EQ(valid.error().code, ErrorCode::kInvalidArgument);
      EXPECT_EQ(valid.error().message.rfind(c.name, 0), 0U) << valid.error().message;
      EXPECT_FALSE(Mapper::make(params));
    }
  for (const int particles : {0, -3, 1001}) {
    MapperParams params;
    params.particles = particles;
    const auto valid = validate(params);
    ASSERT_FALSE(valid);
    EXPECT_EQ(valid.error().message.rfind("particles", 0), 0U);
  }
}

TEST(Mapper, CovarianceIsSymmetricAndPositive) {
  const auto drive = record_room(10);
  Mapper mapper = make_mapper();
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const bool blind = i % 11 == 5;
    const auto update =
        mapper.add(blind ? without_returns(drive.scans[i]) : drive.scans[i], drive.odometry[i]).value();
    const Eigen::Matrix3d& c = update.covariance;
    ASSERT_TRUE(c.allFinite()) << i;
    EXPECT_LT((c - c.transpose()).cwiseAbs().maxCoeff(), 1e-9 * c.cwiseAbs().maxCoeff()) << i;
    EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(c).info(), Eigen::Success) << i;
    if (i > 0) {
      EXPECT_LT(std::sqrt(c(0, 0) + c(1, 1)), i < 5 ? 0.2 : 1.5) << i << ", blind scans leave doubt";
    }
  }
}

TEST(Mapper, WeightsSumToOne) {
  const auto drive = record_drive(planar_loop(), planar_loop_route(0.2, 1), 1);
  MapperParams params;
  params.particles = 50;
  Mapper mapper = make_mapper(params);
  for (std::size_t i = 0; i < 150; ++i) {
    (void)mapper.add(drive.scans[i], drive.odometry[i]).value();
    const auto particles = mapper.particles();
    ASSERT_EQ(particles.size(), 50U);
    double sum = 0;
    for (const auto& particle : particles) {
      EXPECT_GE(particle.weight, 0);
      sum += particle.weight;
    }
    ASSERT_NEAR(sum, 1.0, 1e-9);
    const auto statistics = mapper.statistics();
    EXPECT_GE(statistics.effective_particles, 1 - 1e-9);
    EXPECT_LE(statistics.effective_particles, 50 + 1e-9);
    EXPECT_GE(statistics.entropy, -1e-12);
    EXPECT_LE(statistics.entropy, std::log(50.0) + 1e-9);
  }
}

/// Bytes of the heap in use; no value where the C library does not report it, as under sanitizers.
std::optional<double> heap_bytes() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
  if (info.uordblks > 0) return static_cast<double>(info.uordblks + info.hblkhd);
#endif
  return std::nullopt;
}

TEST(Mapper, OneParticleAndManyMapTheSame) {
  const auto drive = record_room(11);
  std::vector<double> heap;
  std::vector<std::shared_ptr<const OccupancyGrid>> maps;
  for (const int particles : {1, 100}) {
    const auto before = heap_bytes();
    MapperParams params;
    params.particles = particles;
    Mapper mapper = make_mapper(params);
    add_scans(mapper, drive, 0, drive.scans.size());
    mapper.finish();
    maps.push_back(mapper.map());
    if (before) heap.push_back(*heap_bytes() - *before);
  }
  EXPECT_LT(map_difference(*maps[0], *maps[1]), 0.03);
  if (heap.empty()) return;
  EXPECT_GT(heap[0], 1e5);
  EXPECT_LT(heap[1], 1.5 * heap[0]) << "memory grows with the area, not with the particles";
}

TEST(Mapper, OptimizesOnDemandAndGoesOn) {
  const auto drive = record_room(14);
  const std::size_t half = drive.scans.size() / 2;
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, half);
  mapper.optimize();
  EXPECT_LT(drive.error_m(mapper.pose(), half - 1), 0.05);
  const auto update = add_scans(mapper, drive, half, drive.scans.size());
  EXPECT_LT(drive.error_m(update.pose, drive.scans.size() - 1), 0.05);
  mapper.finish();
  EXPECT_LT(drive.error_m(mapper.pose(), drive.scans.size() - 1), 0.05);
  make_mapper().optimize();  // without a scan
}

TEST(Mapper, TakesOverASearchThatEndsLater) {
  const auto drive = record_room(15);
  const std::size_t third = drive.scans.size() / 3;
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, third);
  LoopSearch search = mapper.search();
  search.run();
  add_scans(mapper, drive, third, 2 * third);
  const auto before = mapper.map_version();
  EXPECT_TRUE(mapper.adopt(std::move(search)));
  EXPECT_NE(mapper.map_version(), before);
  EXPECT_LT(drive.error_m(mapper.pose(), 2 * third - 1), 0.05);
  add_scans(mapper, drive, 2 * third, drive.scans.size());
  const auto trajectory = mapper.trajectory();
  ASSERT_EQ(trajectory.size(), drive.scans.size());
  for (std::size_t i = 0; i < trajectory.size(); i += 10)
    EXPECT_LT(drive.error_m(trajectory[i].pose, i), 0.06) << i;
}

TEST(Mapper, ASearchOfAnotherMapChangesNothing) {
  const auto drive = record_room(16);
  const auto other_drive = record_room(17);
  Mapper mapper = make_mapper();
  Mapper other = make_mapper();
  EXPECT_FALSE(mapper.adopt(other.search())) << "neither has a map";
  add_scans(mapper, drive, 0, drive.scans.size());
  const Pose2 pose = mapper.pose();
  add_scans(other, other_drive, 0, other_drive.scans.size());
  EXPECT_FALSE(mapper.adopt(other.search()));
  EXPECT_FALSE(mapper.adopt(make_mapper().search()));
  EXPECT_EQ(pose.x, mapper.pose().x);
}

TEST(Mapper, FarFromKnownSurroundingsThePositionIsKnownLess) {
  const auto drive = record_drive(planar_corridor(), planar_drive({{-4, 0}, {4, 0}}, 0.15, 0.15), 15);
  Mapper mapper = make_mapper();
  double last = 0;
  for (std::size_t i = 0; i < drive.scans.size(); i += 10) {
    const auto update = add_scans(mapper, drive, i, std::min(i + 10, drive.scans.size()));
    const double sigma_m = mapper.statistics().position_sigma_m;
    EXPECT_GE(sigma_m, last);
    const double variance_m2 = update.covariance(0, 0) + update.covariance(1, 1);
    EXPECT_GE(variance_m2, sigma_m * sigma_m);
    last = sigma_m;
  }
  const std::size_t end = drive.scans.size() - 1;
  EXPECT_GT(last, 0.05);
  EXPECT_LT(drive.error_m(mapper.pose(), end), 3 * last) << "which covers the truth";
}

class MapperSession : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path file_{folder_.path() / "a.session"};
};

TEST_F(MapperSession, GoesOnInTheSameFrame) {
  const auto drive = record_room(12);
  const std::size_t half = drive.scans.size() / 2;
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, half);
  mapper.finish();
  const auto before = mapper.map();
  const auto trajectory_before = mapper.trajectory();
  ASSERT_TRUE(mapper.save(file_));
  auto loaded = Mapper::load(file_, {});
  ASSERT_TRUE(loaded) << loaded.error().message;
  while (!loaded->settled()) (void)loaded->map();
  // Key frames that moved less than a part of a cell since they were drawn are redrawn at their poses.
  EXPECT_LT(map_difference(*before, *loaded->map()), 0.03);
  EXPECT_LT(drive.error_m(loaded->pose(), half - 1), kRoomErrorM) << "resumes at the last pose";
  const auto trajectory_after = loaded->trajectory();
  ASSERT_EQ(trajectory_after.size(), half);
  for (std::size_t i = 0; i < half; ++i) {
    EXPECT_EQ(trajectory_after[i].stamp_s, trajectory_before[i].stamp_s);
    EXPECT_NEAR(trajectory_after[i].pose.x, trajectory_before[i].pose.x, 1e-9);
    EXPECT_NEAR(trajectory_after[i].pose.y, trajectory_before[i].pose.y, 1e-9);
    EXPECT_NEAR(wrap_angle(trajectory_after[i].pose.yaw - trajectory_before[i].pose.yaw), 0, 1e-9);
  }
  EXPECT_EQ(loaded->statistics().scans, half);
  EXPECT_EQ(loaded->statistics().key_frames, mapper.statistics().key_frames);
  // Odometry restarted in the meantime.
  for (std::size_t i = half; i < drive.scans.size(); ++i) {
    const auto update = loaded->add(drive.scans[i], compose({30, -8, 2}, drive.odometry[i])).value();
    ASSERT_LT(drive.error_m(update.pose, i), kRoomErrorM) << i;
  }
  EXPECT_EQ(loaded->trajectory().size(), drive.scans.size());
  Mapper in_one_go = make_mapper();
  add_scans(in_one_go, drive, 0, drive.scans.size());
  in_one_go.finish();
  loaded->finish();
  EXPECT_LT(map_difference(*in_one_go.map(), *loaded->map()), 0.1);
}

TEST_F(MapperSession, SavedAgainIsTheSame) {
  const auto drive = record_room(13);
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, 60);
  ASSERT_TRUE(mapper.save(file_));
  auto loaded = Mapper::load(file_, {});
  ASSERT_TRUE(loaded);
  const auto again = folder_.path() / "b.session";
  ASSERT_TRUE(loaded->save(again));
  EXPECT_EQ(std::filesystem::file_size(file_), std::filesystem::file_size(again));
}

TEST_F(MapperSession, WhateverWasTakenCanBeLoaded) {
  const auto drive = record_room(14);
  Mapper mapper = make_mapper();
  for (std::size_t i = 0; i < 40; ++i) {
    LaserScan scan = drive.scans[i];
    if (i == 20) scan.stamp_s = std::numeric_limits<double>::quiet_NaN();
    if (i == 30) scan.stamp_s = std::numeric_limits<double>::infinity();
    (void)mapper.add(scan, drive.odometry[i]);  // refused or taken
  }
  ASSERT_TRUE(mapper.save(file_));
  const auto loaded = Mapper::load(file_, {});
  EXPECT_TRUE(loaded) << loaded.error().message;
}

TEST_F(MapperSession, ErrorsNameTheFile) {
  EXPECT_FALSE(make_mapper().save(file_)) << "no scan was mapped yet";
  const auto missing = Mapper::load(file_, {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("a.session"), std::string::npos);
  const auto other = Mapper::load(folder_.write("other.session", "a PNG image"), {});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(other.error().message.find("other.session"), std::string::npos);
  const auto drive = record_room(15);
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, 5);
  EXPECT_FALSE(mapper.save(folder_.path() / "no" / "such" / "folder"));
  ASSERT_TRUE(mapper.save(file_));
  MapperParams wrong;
  wrong.particles = 0;
  const auto refused = Mapper::load(file_, wrong);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("particles"), std::string::npos);
}

TEST(Mapper, ANewOneForgets) {
  const auto drive = record_room(16);
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, 30);
  mapper = make_mapper();
  EXPECT_TRUE(mapper.trajectory().empty());
  EXPECT_EQ(mapper.statistics().scans, 0U);
  EXPECT_TRUE(mapper.map()->empty());
  EXPECT_TRUE(mapper.settled());
  EXPECT_TRUE(same_bits(mapper.pose(), {}));
  mapper.finish();
  add_scans(mapper, drive, 0, 10);
  EXPECT_LT(drive.error_m(mapper.pose(), 9), kRoomErrorM);
}

TEST(Mapper, WithoutOdometry) {
  const auto drive =
      record_drive(planar_room(), planar_drive({{-3, -1.5}, {2, -1.5}, {3, 1}, {0, 1.2}}, 0.08, 0.08), 17);
  Mapper mapper = make_mapper();
  add_scans(mapper, drive, 0, drive.scans.size(), false);
  EXPECT_LT(drive.error_m(mapper.pose(), drive.scans.size() - 1), kRoomErrorM);
  EXPECT_EQ(mapper.statistics().odometry_contradictions, 0U);
}

}  // namespace
}  // namespace extperfc::mapping
