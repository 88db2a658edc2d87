// Localization in the map that was made, and mapping again from there.
#include <optional>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "extperfc/mapping/mapper.hpp"

#include "test/support/temporary_folder.hpp"
#include "test/unit/mapping/three_rooms.hpp"

namespace extperfc::mapping {
namespace {

constexpr double kRoomyM = 0.06;

class KnownMap : public testing::Test {
 protected:
  void SetUp() override {
    (void)add_scans(mapper_, drive_, 0, mapped_);
    mapper_.finish();
  }
  /// Greatest error of the poses of scans [first, last), which are added.
  double worst_m(std::size_t first, std::size_t last) {
    double worst = 0;
    for (std::size_t i = first; i < last; ++i)
      worst = std::max(worst, drive_.error_m(add_scans(mapper_, drive_, i, i + 1).pose, i));
    return worst;
  }

  static Corners all_rooms_and_back() {
    Corners corners = kThroughAll;
    corners.insert(corners.end(), {{2, 2}, {4, 2.4}, {8, 3}, {12, 3.2}, {14.5, 2}, {11, 2}, {8, 3}});
    return corners;
  }

  std::size_t mapped_{planar_drive(kThroughAll, 0.12, 0.12).size() - 1};
  /// Through all rooms, and once more along another path.
  MapperDrive drive_{drive_through(all_rooms_and_back(), 31)};
  Mapper mapper_{make_mapper()};
};

TEST_F(KnownMap, StaysAsItIs) {
  const std::size_t frames = mapper_.statistics().key_frames;
  const std::size_t poses = mapper_.trajectory().size();
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  EXPECT_EQ(mapper_.mode(), MapperMode::kLocalization);
  const auto version = mapper_.map_version();
  EXPECT_LT(worst_m(mapped_, drive_.scans.size()), kRoomyM);
  EXPECT_EQ(mapper_.statistics().key_frames, frames);
  EXPECT_EQ(mapper_.trajectory().size(), poses);
  EXPECT_EQ(mapper_.map_version(), version);
  EXPECT_EQ(mapper_.statistics().carried, 0U);
}

TEST_F(KnownMap, MappingGoesOnFromTheLocalizedPose) {
  const std::size_t half = (mapped_ + drive_.scans.size()) / 2;
  const std::size_t frames = mapper_.statistics().key_frames;
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  EXPECT_LT(worst_m(mapped_, half), kRoomyM);
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kMapping));
  EXPECT_EQ(mapper_.mode(), MapperMode::kMapping);
  EXPECT_LT(worst_m(half, drive_.scans.size()), kRoomyM);
  mapper_.finish();
  EXPECT_GT(mapper_.statistics().key_frames, frames + 10);
  EXPECT_EQ(mapper_.statistics().parts, 1U);
  EXPECT_LT(drive_.error_m(mapper_.pose(), drive_.scans.size() - 1), kRoomyM);
}

TEST_F(KnownMap, ARobotThatWasCarriedSaysSoAndIsPutThere) {
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  const MapperDrive third = drive_through(kBackFromThird, 77);
  MapperUpdate update;
  for (std::size_t i = 0; i < 10; ++i) update = mapper_.add(third.scans[i], third.odometry[i]).value();
  EXPECT_TRUE(update.lost);
  EXPECT_FALSE(update.carried) << "no new part of the map during localization";
  const Pose2 start{kThroughAll[0].x(), kThroughAll[0].y(),
                    planar_drive(kThroughAll, 0.12, 0.12).front().yaw};
  const Pose2 put_down = between(start, planar_drive(kBackFromThird, 0.12, 0.12).front());
  const Pose2 roughly{put_down.x + 0.4, put_down.y - 0.3, put_down.yaw + 0.2};
  ASSERT_TRUE(mapper_.put_at(roughly, Eigen::Vector3d(0.3, 0.3, 0.1).asDiagonal()));
  for (std::size_t i = 0; i < third.scans.size(); ++i) {
    update = mapper_.add(third.scans[i], third.odometry[i]).value();
    const Pose2 off = between(compose(put_down, third.truth[i]), update.pose);
    EXPECT_LT(std::hypot(off.x, off.y), 0.1) << i;
  }
  EXPECT_FALSE(update.lost);
}

TEST_F(KnownMap, TheRobotMovesWithAMapThatIsOptimized) {
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  const std::size_t half = (mapped_ + drive_.scans.size()) / 2;
  (void)worst_m(mapped_, half);
  mapper_.optimize();
  EXPECT_LT(drive_.error_m(mapper_.pose(), half - 1), kRoomyM);
  EXPECT_LT(worst_m(half, drive_.scans.size()), kRoomyM);
}

TEST_F(KnownMap, OfASavedSession) {
  const TemporaryFolder folder;
  ASSERT_TRUE(mapper_.save(folder.path() / "rooms.session"));
  mapper_ = std::move(Mapper::load(folder.path() / "rooms.session", {}).value());
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  EXPECT_LT(worst_m(mapped_, drive_.scans.size()), kRoomyM);
}

/// Where nothing is mapped the pose follows odometry, and the covariance says how far it may be off.
TEST_F(KnownMap, OutOfTheMapTheCovarianceGrows) {
  ASSERT_TRUE(mapper_.set_mode(MapperMode::kLocalization));
  const double known =
      add_scans(mapper_, drive_, mapped_, mapped_ + 5).covariance.topLeftCorner<2, 2>().trace();
  LaserScan blind = drive_.scans[mapped_];
  blind.ranges.assign(blind.ranges.size(), std::numeric_limits<float>::infinity());
  MapperUpdate update;
  for (std::size_t i = 0; i < 50; ++i) {
    Pose2 odometry = drive_.odometry[mapped_ + 4];
    odometry.x += 0.1 * static_cast<double>(i + 1);
    update = mapper_.add(blind, odometry).value();
  }
  EXPECT_EQ(update.status, ScanStatus::kUnusable);
  const double unknown = update.covariance.topLeftCorner<2, 2>().trace();
  EXPECT_GT(unknown, 10 * known);
}

TEST(MapperModes, NoLocalizationWithoutAMap) {
  Mapper mapper = make_mapper();
  EXPECT_FALSE(mapper.set_mode(MapperMode::kLocalization));
  EXPECT_TRUE(mapper.set_mode(MapperMode::kMapping));
  EXPECT_EQ(mapper.mode(), MapperMode::kMapping);
}

}  // namespace
}  // namespace extperfc::mapping
