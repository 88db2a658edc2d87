#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/moving_objects.hpp"

#include "test/support/building.hpp"

namespace extperfc::navigate {
namespace {

/// An 8 x 6 m room, and what is not on its map.
struct Room8 {
  Building building;
  std::vector<FloorDisc> discs;

  Room8() {
    building.size_m = {8, 6};
    building.enclose();
    building.add(6.0, 4.0, 6.3, 4.3);  // a pillar: of a person's size, but on the map
  }

  [[nodiscard]] OccupancyGrid map() const { return occupancy_of(building); }
  [[nodiscard]] LaserScan scan(const Pose2& pose, Rng& rng) const {
    return scan_of(building, discs, pose, rng);
  }
};

TEST(MovingObjects, TheMapExplainsWallsAndPillars) {
  const Room8 room;
  MovingObjectDetector detector({});
  detector.set_map(room.map());
  Rng rng(5);
  for (int i = 0; i < 30; ++i) {
    const Pose2 pose{rng.uniform(1, 5), rng.uniform(1, 5), rng.uniform(-kPi, kPi)};
    EXPECT_TRUE(detector.detect(room.scan(pose, rng), pose).empty()) << i;
  }
}

TEST(MovingObjects, FindsPeopleWhereTheyAre) {
  Rng rng(6);
  MovingObjectDetector detector({});
  detector.set_map(Room8().map());
  int found = 0;
  for (int i = 0; i < 50; ++i) {
    Room8 room;
    const Pose2 pose{rng.uniform(1, 3), rng.uniform(1, 5), rng.uniform(-kPi, kPi)};
    const Eigen::Vector2d person(rng.uniform(4.2, 5.5), rng.uniform(1, 5));
    room.discs.push_back({person, 0.22});
    const auto candidates = detector.detect(room.scan(pose, rng), pose);
    ASSERT_EQ(candidates.size(), 1U) << i;
    // The side that the scanner sees is nearer than the middle.
    if ((candidates[0].centre_m - person).norm() < 0.25) ++found;
    EXPECT_GE(candidates[0].radius_m, 0.1);
    EXPECT_LE(candidates[0].radius_m, 0.6);
  }
  EXPECT_EQ(found, 50);
}

TEST(MovingObjects, WhoWalksIsSeenThoughAMapThatGrowsShowsThem) {
  Rng rng(9);
  const Pose2 pose{1.5, 2.5, 0.4};
  const Eigen::Vector2d person(4.5, 2.8);
  Room8 room;
  room.discs.push_back({person, 0.22});
  Room8 mapped;
  mapped.building.add(person.x() - 0.2, person.y() - 0.2, person.x() + 0.2, person.y() + 0.2);
  const std::vector<MovingObstacle> pedestrians{{person, {0.5, 0}, 0.25}};

  const auto before = Room8().map();
  const auto after = mapped.map();
  MovingObjectDetector detector({});
  detector.set_map(before, 10);
  detector.set_map(after, 11);
  EXPECT_TRUE(detector.detect(room.scan(pose, rng), pose).empty()) << "part of the map";
  ASSERT_EQ(detector.detect(room.scan(pose, rng), pose, pedestrians).size(), 1U);
  const std::vector<MovingObstacle> elsewhere{{{2.5, 4.5}, {0.5, 0}, 0.25}};
  EXPECT_TRUE(detector.detect(room.scan(pose, rng), pose, elsewhere).empty());
  for (int i = 1; i <= 31; ++i) detector.set_map(after, 11 + 0.1 * i);
  EXPECT_TRUE(detector.detect(room.scan(pose, rng), pose, pedestrians).empty())
      << "it has stood there for long";
  detector.set_map(before, 2);
  EXPECT_EQ(detector.detect(room.scan(pose, rng), pose).size(), 1U) << "another clock, another beginning";
}

TEST(MovingObjects, TwoLegsAreOnePersonAndTwoPeopleAreTwo) {
  Room8 room;
  room.discs = {{{3.0, 2.9}, 0.07}, {{3.1, 3.2}, 0.07}, {{2.0, 4.6}, 0.07}, {{2.2, 4.5}, 0.07}};
  MovingObjectDetector detector({});
  detector.set_map(room.map());
  Rng rng(7);
  const Pose2 pose{1, 3, 0};
  const auto candidates = detector.detect(room.scan(pose, rng), pose);
  ASSERT_EQ(candidates.size(), 2U);
  for (const MovingCandidate& candidate : candidates) {
    const bool first = (candidate.centre_m - Eigen::Vector2d(3.05, 3.05)).norm() < 0.2;
    const bool second = (candidate.centre_m - Eigen::Vector2d(2.1, 4.55)).norm() < 0.2;
    EXPECT_TRUE(first || second) << candidate.centre_m.transpose();
  }
}

TEST(MovingObjects, PeopleWhoPassEachOtherStayTwo) {
  MovingObjectDetector detector({});
  detector.set_map(Room8().map());
  Rng rng(8);
  for (int i = 0; i < 20; ++i) {
    Room8 room;
    const Eigen::Vector2d middle(rng.uniform(3, 5), rng.uniform(2.2, 3.8));
    const double angle = rng.uniform(1.2, 1.9);  // side by side as the scanner sees them
    const Eigen::Vector2d half = rng.uniform(0.23, 0.3) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    room.discs = {{middle + half, 0.2}, {middle - half, 0.2}};
    const std::vector<MovingObstacle> known{{middle + half, {0.5, 0}, 0.25}, {middle - half, {0.7, 0}, 0.25}};
    const auto candidates = detector.detect(room.scan({1, 3, 0}, rng), {1, 3, 0}, known);
    ASSERT_EQ(candidates.size(), 2U) << i;
    for (const MovingObstacle& person : known) {
      const auto is_near = [&](const MovingCandidate& one) {
        return (one.centre_m - person.position_m).norm() < 0.2;
      };
      EXPECT_EQ(std::count_if(candidates.begin(), candidates.end(), is_near), 1) << i;
    }
  }
}

TEST(MovingObjects, TwoTracksOfOnePersonAreOneCandidate) {
  Room8 room;
  room.discs = {{{3.0, 2.9}, 0.07}, {{3.1, 3.2}, 0.07}};
  MovingObjectDetector detector({});
  detector.set_map(room.map());
  Rng rng(10);
  const std::vector<MovingObstacle> tracks{{{3.0, 2.9}, {0.5, 0}, 0.25}, {{3.1, 3.2}, {0.5, 0}, 0.25}};
  EXPECT_EQ(detector.detect(room.scan({1, 3, 0}, rng), {1, 3, 0}, tracks).size(), 1U);
}

TEST(MovingObjects, WhoPassesAWallIsNoPartOfWhatHangsThere) {
  MovingObjectDetector detector({});
  detector.set_map(Room8().map());
  Rng rng(11);
  for (int i = 0; i < 20; ++i) {
    Room8 room;
    const Eigen::Vector2d person(rng.uniform(2.7, 3.3), rng.uniform(2.945, 2.975));
    room.building.add(2.7, 3.38, 3.3, 3.42);  // a board that the map does not show
    room.discs = {{person, 0.2}, {person + Eigen::Vector2d(-0.05, -0.24), 0.05}};
    const Pose2 pose{rng.uniform(0.6, 1.2), rng.uniform(2.5, 3.1), 0};
    const std::vector<MovingObstacle> known{{person + Eigen::Vector2d(0.05, 0), {0.7, 0}, 0.25}};
    const auto candidates = detector.detect(room.scan(pose, rng), pose, known);
    const auto is_person = [&](const MovingCandidate& one) {
      return (one.centre_m - person).norm() < 0.2 && one.radius_m < 0.35;
    };
    EXPECT_EQ(std::count_if(candidates.begin(), candidates.end(), is_person), 1) << i;
  }
}

TEST(MovingObjects, WithoutPeopleWhatElseWasSeenStays) {
  Room8 room;
  const Pose2 pose{1, 3, 0.4};
  Rng of_empty(8);
  Rng of_full(8);
  const LaserScan empty = room.scan(pose, of_empty);
  room.discs = {{{3.0, 3.0}, 0.25}, {{2.5, 4.6}, 0.25}};
  const LaserScan full = room.scan(pose, of_full);
  const std::vector<MovingObstacle> people{{{3.05, 2.95}, {0.5, 0}, 0.25}, {{2.5, 4.6}, {0, 0}, 0.25}};
  const LaserScan rest = without(full, people, pose);
  int gone = 0;
  for (std::size_t i = 0; i < rest.ranges.size(); ++i) {
    const bool person = full.ranges[i] < empty.ranges[i] - 0.1F;
    EXPECT_EQ(std::isnan(rest.ranges[i]), person) << i;
    gone += person ? 1 : 0;
  }
  EXPECT_GT(gone, 30);
  EXPECT_EQ(without(full, {}, pose).ranges, full.ranges);
}

TEST(MovingObjects, PointsOfPeopleAreLeftOutAtAnyHeight) {
  const std::vector<MovingObstacle> people{{{2, 1}, {0, 0}, 0.3}};
  const auto rest = without({{2, 1, 0.1F}, {2.4F, 1, 1.7F}, {2.5F, 1, 0.5F}, {0, 0, 0}}, people);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest[0], Eigen::Vector3f(2.5F, 1, 0.5F));
  EXPECT_EQ(rest[1], Eigen::Vector3f(0, 0, 0));
}

TEST(MovingObjects, ACabinetIsNoPerson) {
  Room8 room;
  MovingObjectDetector detector({});
  detector.set_map(room.map());
  room.building.add(3, 2, 3.4, 4);
  Rng rng(8);
  const Pose2 pose{1, 3, 0};
  EXPECT_TRUE(detector.detect(room.scan(pose, rng), pose).empty());
}

TEST(MovingObjects, ASweepsEndIsItsBeginning) {
  Room8 room;
  room.discs.push_back({{3.0, 3.0}, 0.25});
  MovingObjectDetector detector({});
  detector.set_map(room.map());
  Rng rng(9);
  const Pose2 pose{5, 3, 0};  // the person is behind, where the sweep begins and ends
  const auto candidates = detector.detect(room.scan(pose, rng), pose);
  ASSERT_EQ(candidates.size(), 1U);
  EXPECT_NEAR(candidates[0].centre_m.y(), 3.0, 0.1);
}

TEST(MovingObjects, ReturnsThatDoNotCountAreNone) {
  MovingObjectDetector detector({});
  LaserScan scan;
  scan.angle_increment = 0.01;
  scan.range_min = 0.1;
  scan.range_max = 5;
  scan.ranges = {NAN, 0, -1, 0.05F, INFINITY, 6};
  EXPECT_TRUE(detector.detect(scan, {}).empty());
  EXPECT_THROW(MovingObjectDetector({0}), std::invalid_argument);
}

}  // namespace
}  // namespace extperfc::navigate
