#include <cmath>

#include <gtest/gtest.h>

#include "simulate/control/walker.hpp"

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

void walk(Walker& walker, double seconds, const Pose2& robot = kFarAway) {
  for (int i = 0; i < std::lround(seconds / kStep); ++i) walker.step(kStep, robot);
}

TEST(Walker, GoesThereAndBackOnAnOpenPath) {
  Walker walker(person({{0, 0}, {2, 0}}, false));
  walk(walker, 1.0);
  EXPECT_NEAR(walker.pose().x, 1.0, 0.01);
  EXPECT_NEAR(walker.pose().yaw, 0.0, 1e-6);
  walk(walker, 2.0);
  EXPECT_NEAR(walker.pose().x, 1.0, 0.01);
  EXPECT_NEAR(std::abs(walker.pose().yaw), M_PI, 1e-6);
}

TEST(Walker, GoesRoundOnAClosedPath) {
  Walker walker(person({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, true));
  walk(walker, 3.5);
  EXPECT_NEAR(walker.pose().x, 0.0, 0.01);
  EXPECT_NEAR(walker.pose().y, 0.5, 0.01);
  walk(walker, 0.5);
  EXPECT_NEAR(walker.pose().y, 0.0, 0.01);
}

TEST(Walker, WaitsForTheRobotAheadAndPassesOneBehind) {
  Walker walker(person({{0, 0}, {4, 0}}, false));
  walk(walker, 3.0, Pose2{2, 0, 0});
  EXPECT_NEAR(walker.pose().x, 2.0 - 1.0, 0.01);
  walk(walker, 1.0, Pose2{0.8, 0, 0});
  EXPECT_GT(walker.pose().x, 2.0);
}

TEST(Walker, StandsWithoutAPath) {
  Walker walker(person({{3, 4}}, false));
  walk(walker, 1.0);
  EXPECT_EQ(walker.pose().x, 3);
  EXPECT_EQ(walker.pose().y, 4);
}

}  // namespace
}  // namespace extperfc::simulate
