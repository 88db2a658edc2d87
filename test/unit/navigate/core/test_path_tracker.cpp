// Where on its path the robot is.
#include <gtest/gtest.h>

#include "test/unit/navigate/core/fake_robot.hpp"

namespace extperfc::navigate::test {
namespace {

TEST(PathTracker, MeasuresWhatIsLeftAndHowFarThePathIs) {
  PathTracker tracker;
  EXPECT_TRUE(tracker.empty());
  EXPECT_EQ(tracker.rest_m(), 0);
  tracker.set(straight({0, 0, 0}, {5, 0, 0}));
  EXPECT_NEAR(tracker.rest_m(), 5, 1e-9);
  tracker.update({1.0, 0.3, 0});
  EXPECT_NEAR(tracker.rest_m(), 4, 1e-9);
  EXPECT_NEAR(tracker.deviation_m(), 0.3, 1e-9);
}

TEST(PathTracker, FollowsAPathThatCrossesItselfInOrder) {
  Path path = straight({0, 0, 0}, {4, 0, 0});
  for (const auto& part :
       {straight({4, 0, 0}, {4, 2, 0}), straight({4, 2, 0}, {2, 2, 0}), straight({2, 2, 0}, {2, -2, 0})})
    path.poses.insert(path.poses.end(), part.poses.begin() + 1, part.poses.end());
  PathTracker tracker;
  tracker.set(path);
  for (double x = 0; x <= 2.0; x += 0.1) tracker.update({x, 0, 0});
  EXPECT_NEAR(tracker.rest_m(), 2 + 2 + 2 + 4, 0.15) << "at the crossing for the first time";
}

TEST(PathTracker, AfterAJumpTheWholePathIsSearched) {
  PathTracker tracker;
  tracker.set(straight({0, 0, 0}, {9, 0, 0}));
  tracker.update({7, 0, 0});
  EXPECT_NEAR(tracker.rest_m(), 2, 0.01);
}

TEST(PathTracker, TheRestInAnotherFrame) {
  PathTracker tracker;
  tracker.set(straight({0, 0, 0}, {2, 0, 0}));
  tracker.update({1, 0, 0});
  const auto rest = tracker.rest_in({10, 0, 1.5707963});
  EXPECT_NEAR(rest.poses.front().y, 1, 1e-6);
  EXPECT_NEAR(rest.poses.back().x, 10, 1e-6);
  EXPECT_NEAR(rest.poses.back().y, 2, 1e-6);
  EXPECT_NEAR(rest.poses.back().yaw, 1.5707963, 1e-6);
}

TEST(PathTracker, FindsWhatBlocksAhead) {
  FakeRobot robot;
  robot.block({2, 0}, 0.1);
  PathTracker tracker;
  tracker.set(straight({0, 0, 0}, {3, 0, 0}));
  const auto blocked = tracker.blocked(robot.costs, robot.footprint, {}, 10);
  ASSERT_TRUE(blocked);
  EXPECT_NEAR(blocked->x, 1.55, 0.1);
  EXPECT_FALSE(tracker.blocked(robot.costs, robot.footprint, {}, 1.0)) << "beyond what is asked for";
  EXPECT_FALSE(tracker.blocked(robot.costs, robot.footprint, {0, 2, 0}, 10)) << "in another frame";
  tracker.update({2.9, 0, 0});
  EXPECT_FALSE(tracker.blocked(robot.costs, robot.footprint, {}, 10)) << "it lies behind";
}

}  // namespace
}  // namespace extperfc::navigate::test
