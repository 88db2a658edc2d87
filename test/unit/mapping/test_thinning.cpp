// A robot that drives the same rounds for hours: the map keeps what it needs.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/mapping/mapper.hpp"

#include "mapping/thinning.hpp"
#include "test/support/temporary_folder.hpp"
#include "test/unit/mapping/three_rooms.hpp"

namespace extperfc::mapping {
namespace {

struct Path {
  std::vector<KeyFrame> frames;
  std::vector<Pose2> poses;

  void add(const Pose2& pose) {
    KeyFrame frame;
    frame.points.surface.resize(20);
    frames.push_back(frame);
    poses.push_back(pose);
  }
  /// Rounds of 104 key frames on a circle.
  void add_rounds(std::size_t rounds) {
    constexpr std::size_t kFrames = 104;
    for (std::size_t i = 0; i < rounds * kFrames; ++i) {
      const double angle = 2 * M_PI * static_cast<double>(i % kFrames) / static_cast<double>(kFrames);
      add({5 * std::cos(angle), 5 * std::sin(angle), wrap_angle(angle + M_PI / 2)});
    }
  }
  std::size_t thin_all(std::size_t kept_passes) {
    std::size_t all = 0;
    for (auto often = seen_often(frames, poses, kept_passes); !often.empty();
         often = seen_often(frames, poses, kept_passes)) {
      for (const std::size_t i : often) frames[i].points = {};
      all += often.size();
    }
    return all;
  }
};

TEST(SeenOften, NeverWithFewPasses) {
  Path path;
  path.add_rounds(4);
  EXPECT_TRUE(seen_often(path.frames, path.poses, 2).empty());
}

TEST(SeenOften, ThePassesBetweenOldAndNewOnes) {
  Path path;
  path.add_rounds(12);
  EXPECT_GT(path.thin_all(2), 6 * 104U);
  for (std::size_t i = 0; i < 2 * 104; ++i) EXPECT_FALSE(path.frames[i].is_thinned()) << i;
  for (std::size_t i = 10 * 104; i < 12 * 104; ++i) EXPECT_FALSE(path.frames[i].is_thinned()) << i;
}

TEST(SeenOften, NoMoreThanABoundedNumberAtOnce) {
  Path path;
  path.add_rounds(12);
  EXPECT_EQ(seen_often(path.frames, path.poses, 2).size(), 32U);
}

TEST(SeenOften, NothingWhenAllPassesAreWanted) {
  Path path;
  path.add_rounds(12);
  EXPECT_TRUE(seen_often(path.frames, path.poses, 0).empty());
}

TEST(SeenOften, AnotherHeadingIsAnotherView) {
  Path path;
  path.add_rounds(3);
  const std::size_t one_way = path.poses.size();
  path.add_rounds(3);
  for (std::size_t i = one_way; i < path.poses.size(); ++i)
    path.poses[i].yaw = wrap_angle(path.poses[i].yaw + M_PI);
  EXPECT_EQ(path.thin_all(2), 0U);
}

Corners rounds(std::size_t count) {
  const Corners round = {{2, 2}, {4, 3}, {8, 3}, {10, 2}, {14, 3.5}, {12, 4.2}, {8, 3}, {5, 4}};
  Corners corners;
  for (std::size_t i = 0; i < count; ++i) corners.insert(corners.end(), round.begin(), round.end());
  return corners;
}

class ManyRounds : public testing::Test {
 protected:
  static constexpr std::size_t kRounds = 10;

  [[nodiscard]] static std::size_t with_scans(const Mapper& mapper) {
    return mapper.statistics().key_frames - mapper.statistics().thinned_key_frames;
  }

  MapperDrive drive_{record_drive(three_rooms(), planar_drive(rounds(kRounds), 0.2, 0.2), 5)};
  std::size_t half_{drive_.scans.size() / 2};
  Mapper mapper_{make_mapper()};
};

TEST_F(ManyRounds, MemoryGrowsWithTheBuildingNotWithTheTime) {
  (void)add_scans(mapper_, drive_, 0, half_);
  const std::size_t after_half = with_scans(mapper_);
  (void)add_scans(mapper_, drive_, half_, drive_.scans.size());
  EXPECT_LT(static_cast<double>(with_scans(mapper_)), 1.25 * static_cast<double>(after_half));
  EXPECT_GT(mapper_.statistics().thinned_key_frames, after_half / 2);
  const Trajectory trajectory = mapper_.trajectory();
  ASSERT_EQ(trajectory.size(), drive_.scans.size());
  for (std::size_t i = 0; i < trajectory.size(); i += 20)
    EXPECT_LT(drive_.error_m(trajectory[i].pose, i), 0.06) << i;
}

TEST_F(ManyRounds, TheMapStays) {
  MapperParams everything;
  everything.kept_passes = 0;
  Mapper all = make_mapper(everything);
  const std::size_t enough = drive_.scans.size() * 6 / 10;
  (void)add_scans(mapper_, drive_, 0, enough);
  (void)add_scans(all, drive_, 0, enough);
  EXPECT_GT(mapper_.statistics().thinned_key_frames, 0U);
  EXPECT_EQ(all.statistics().thinned_key_frames, 0U);
  EXPECT_LT(map_difference(*mapper_.map(), *all.map()), 0.05);
  mapper_.finish();
  EXPECT_LT(map_difference(*mapper_.map(), *all.map()), 0.05);
  const Trajectory trajectory = mapper_.trajectory();
  for (std::size_t i = 0; i < trajectory.size(); i += 20)
    EXPECT_LT(drive_.error_m(trajectory[i].pose, i), 0.06) << i;
}

TEST_F(ManyRounds, ASessionGoesOn) {
  (void)add_scans(mapper_, drive_, 0, half_);
  const TemporaryFolder folder;
  ASSERT_TRUE(mapper_.save(folder.path() / "rounds.session"));
  Mapper loaded = std::move(Mapper::load(folder.path() / "rounds.session", {}).value());
  EXPECT_GT(loaded.statistics().thinned_key_frames, 0U);
  EXPECT_EQ(loaded.statistics().thinned_key_frames, mapper_.statistics().thinned_key_frames);
  (void)add_scans(loaded, drive_, half_, half_ + 100);
  EXPECT_LT(drive_.error_m(loaded.pose(), half_ + 99), 0.06);
}

}  // namespace
}  // namespace extperfc::mapping
