#include <cmath>

#include <gtest/gtest.h>

#include "simulate/control/pedestrian.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kStep = 1.0 / 240;
constexpr Pose2 kFarAway{100, 100, 0};

PersonSpec person(std::vector<Eigen::Vector2d> path, bool closed) {
  PersonSpec spec;
  spec.path_m = std::move(path);
  spec.speed_m_s = 1.0;
  spec.closed = closed;
  return spec;
}

void walk(Pedestrian& pedestrian, double seconds, const Pose2& robot = kFarAway) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) pedestrian.step(kStep, robot);
}

TEST(Pedestrian, GoesThereAndBackOnAnOpenPath) {
  Pedestrian pedestrian(person({{0, 0}, {2, 0}}, false));
  walk(pedestrian, 1.0);
  EXPECT_NEAR(pedestrian.pose().x, 1.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().yaw, 0.0, 1e-6);
  walk(pedestrian, 2.0);
  EXPECT_NEAR(pedestrian.pose().x, 1.0, 0.01);
  EXPECT_NEAR(std::abs(pedestrian.pose().yaw), M_PI, 1e-6);
}

TEST(Pedestrian, StandsAtPointsOfThePathOnce) {
  auto spec = person({{0, 0}, {2, 0}, {2, 1}}, false);
  spec.stands_s = {2.0, 3.0};
  Pedestrian pedestrian(spec);
  walk(pedestrian, 1.9);
  EXPECT_EQ(pedestrian.pose().x, 0.0);
  walk(pedestrian, 1.1);
  EXPECT_NEAR(pedestrian.pose().x, 1.0, 0.01);
  walk(pedestrian, 3.5);
  EXPECT_NEAR(pedestrian.pose().x, 2.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().y, 0.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().yaw, 0.0, 0.01) << "looks where it was going";
  walk(pedestrian, 1.0);
  EXPECT_NEAR(pedestrian.pose().y, 0.5, 0.01);
  walk(pedestrian, 2.0);  // there, and back to the second point
  walk(pedestrian, 1.0);
  EXPECT_NEAR(pedestrian.pose().x, 0.5, 0.02) << "not again on the path back";
}

TEST(Pedestrian, GoesRoundOnAClosedPath) {
  Pedestrian pedestrian(person({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, true));
  walk(pedestrian, 3.5);
  EXPECT_NEAR(pedestrian.pose().x, 0.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().y, 0.5, 0.01);
  walk(pedestrian, 0.5);
  EXPECT_NEAR(pedestrian.pose().y, 0.0, 0.01);
}

TEST(Pedestrian, WaitsForTheRobotAheadAndPassesOneBehind) {
  Pedestrian pedestrian(person({{0, 0}, {4, 0}}, false));
  walk(pedestrian, 3.0, Pose2{2, 0, 0});
  EXPECT_NEAR(pedestrian.pose().x, 2.0 - 1.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().yaw, 0.0, 1e-6);
  walk(pedestrian, 1.0, Pose2{0.8, 0, 0});
  EXPECT_GT(pedestrian.pose().x, 2.0);
}

TEST(Pedestrian, LooksWhereItWentWhileItWaits) {
  Pedestrian pedestrian(person({{0, 0}, {0, 4}}, false));
  walk(pedestrian, 3.0, Pose2{0, 2, 0});
  EXPECT_NEAR(pedestrian.pose().y, 1.0, 0.01);
  EXPECT_NEAR(pedestrian.pose().yaw, M_PI / 2, 1e-6);
}

TEST(Pedestrian, WalksBackWhenTheRobotStays) {
  Pedestrian pedestrian(person({{0, 0}, {4, 0}, {4, 3}}, true));
  const Pose2 robot{2, 0, 0};
  walk(pedestrian, 1.0 + 3.0 + 1.5, robot);
  EXPECT_NEAR(pedestrian.pose().x, 0.4, 0.05) << "past the start, on the closed path's last segment";
  EXPECT_GT(pedestrian.pose().y, 0.2);
  walk(pedestrian, 30.0, robot);
  EXPECT_GT(std::hypot(pedestrian.pose().x - robot.x, pedestrian.pose().y - robot.y), 0.99);
}

TEST(Pedestrian, WalksBackFromARobotThatGivesGroundTooSlowly) {
  Pedestrian pedestrian(person({{0, 0}, {10, 0}}, false));
  Pose2 robot{2, 0, 0};
  for (int i = 0; i < std::lround(9 / kStep); ++i) {
    robot.x += 0.2 * kStep;
    pedestrian.step(kStep, robot);
  }
  EXPECT_LT(pedestrian.pose().x, robot.x - 2) << "does not push it on";
}

TEST(Pedestrian, StandsWithoutAPath) {
  Pedestrian pedestrian(person({{3, 4}}, false));
  walk(pedestrian, 1.0);
  EXPECT_EQ(pedestrian.pose().x, 3);
  EXPECT_EQ(pedestrian.pose().y, 4);
}

}  // namespace
}  // namespace extperfc::simulate
