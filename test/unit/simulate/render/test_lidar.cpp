// The lidar's points in a room whose walls are known.

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/render/lidar.hpp"
#include "test/unit/simulate/render/small_world.hpp"

namespace extperfc::simulate {
namespace {

const Eigen::Vector3d kHalfRoom(5, 4, 3);

/// The room's walls are the inner sides of a box around the origin.
SmallWorld room() {
  SmallWorld world;
  world.add("room", Box{2 * kHalfRoom}, at(0, 0, 0), {{1, 1, 1}});
  return world;
}

LidarParams few_columns(int columns = 361) {
  auto params = exact_lidar();
  params.columns = columns;
  return params;
}

std::vector<LidarPoint> sweep(SensorRig& rig, const LidarParams& params, const Pose& begin, const Pose& end) {
  std::vector<LidarPoint> points;
  rig.lidar(params, begin, end, points);
  return points;
}

double range_of(const LidarPoint& p) {
  return Eigen::Vector3d(p.x, p.y, p.z).norm();
}

/// Distance of a point from the nearest wall's plane.
double off_the_wall(const Eigen::Vector3d& world) {
  return (kHalfRoom - world.cwiseAbs()).cwiseAbs().minCoeff();
}

TEST(Lidar, EveryRingMeasuresTheWalls) {
  const auto rig = room().rig();
  const auto points = sweep(*rig, few_columns(), at(0, 0, 0), at(0, 0, 0));
  ASSERT_EQ(points.size(), 361U * 16U);
  for (const auto& p : points) {
    const Eigen::Vector3d direction = Eigen::Vector3d(p.x, p.y, p.z).normalized();
    const double expected = (kHalfRoom.array() / direction.array().abs()).minCoeff();
    ASSERT_NEAR(range_of(p), expected, 1e-3) << "ring " << p.ring;
  }
}

TEST(Lidar, RingsAreTwoDegreesApartFromTheLowest) {
  const auto rig = room().rig();
  for (const auto& p : sweep(*rig, few_columns(), at(0, 0, 0), at(0, 0, 0))) {
    const double elevation = std::asin(p.z / range_of(p)) * 180 / M_PI;
    ASSERT_NEAR(elevation, -15 + 2 * p.ring, 1e-3);
  }
}

TEST(Lidar, ColumnsTurnClockwiseAndLasersFireInTurn) {
  const auto rig = room().rig();
  const auto params = few_columns();
  const auto points = sweep(*rig, params, at(0, 0, 0), at(0, 0, 0));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto column = static_cast<double>(i / 16);
    ASSERT_EQ(points[i].ring, i % 16);
    ASSERT_NEAR(points[i].time, column / 3610 + ring_delay_s(points[i].ring), 1e-7);
    const double azimuth = std::atan2(points[i].y, points[i].x);
    ASSERT_NEAR(std::remainder(azimuth + 2 * M_PI * 10 * points[i].time, 2 * M_PI), 0.0, 1e-4);
  }
}

TEST(Lidar, LasersAlternateBetweenLowAndHigh) {
  // Firing order of the sensor: -15, +1, -13, +3, ... +15 degrees, 2.304 us apart.
  EXPECT_DOUBLE_EQ(ring_delay_s(0), 0);
  EXPECT_DOUBLE_EQ(ring_delay_s(8), 2.304e-6);
  EXPECT_DOUBLE_EQ(ring_delay_s(1), 2 * 2.304e-6);
  EXPECT_DOUBLE_EQ(ring_delay_s(15), 15 * 2.304e-6);
}

TEST(Lidar, AMovingSensorSeesFromWhereItIs) {
  const auto rig = room().rig();
  const auto params = few_columns();
  const Pose begin = at(-1, 0, 0.2);
  const Pose end = make_pose({0.5, 0.4, 0.2}, {0, 0, 0.7});
  const auto points = sweep(*rig, params, begin, end);
  double worst_without = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double fraction = static_cast<double>(i / 16) / params.columns;
    const Pose there = make_pose(begin.translation() + fraction * (end.translation() - begin.translation()),
                                 {0, 0, 0.7 * fraction});
    const Eigen::Vector3d p(points[i].x, points[i].y, points[i].z);
    ASSERT_LT(off_the_wall(there * p), 2e-3);
    worst_without = std::max(worst_without, off_the_wall(begin * p));
  }
  EXPECT_GT(worst_without, 0.3);  // the motion is in the points
}

TEST(Lidar, RangeNoiseHasItsSigmaAndQuantum) {
  const auto rig = room().rig();
  auto params = few_columns(1875);
  const auto exact = sweep(*rig, params, at(0, 0, 0), at(0, 0, 0));
  params.range_noise_m = 0.01;
  params.quantum_m = 0.002;
  const auto noisy = sweep(*rig, params, at(0, 0, 0), at(0, 0, 0));
  ASSERT_EQ(exact.size(), noisy.size());
  double sum2 = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double range = range_of(noisy[i]);
    sum2 += std::pow(range - range_of(exact[i]), 2);
    ASSERT_NEAR(range / 0.002, std::round(range / 0.002), 0.01);
  }
  const double expected = std::sqrt(1e-4 + 0.002 * 0.002 / 12);
  // 30,000 values: 0.41 %, five of them.
  EXPECT_NEAR(std::sqrt(sum2 / static_cast<double>(exact.size())), expected, 0.021 * expected);
}

TEST(Lidar, DropsAsManyAsAsked) {
  const auto rig = room().rig();
  auto params = few_columns(1875);
  params.drop_probability = 0.1;
  const double kept = static_cast<double>(sweep(*rig, params, at(0, 0, 0), at(0, 0, 0)).size());
  EXPECT_NEAR(kept, 27000, 5 * std::sqrt(30000 * 0.09));
}

TEST(Lidar, NothingOutsideItsRange) {
  const auto rig = room().rig();
  auto params = few_columns();
  params.max_range_m = 4.5;
  params.min_range_m = 4.1;
  const auto points = sweep(*rig, params, at(0, 0, 0), at(0, 0, 0));
  EXPECT_FALSE(points.empty());
  for (const auto& p : points) {
    EXPECT_GE(range_of(p), 4.1 - 1e-4);
    EXPECT_LE(range_of(p), 4.5 + 1e-4);
  }
}

TEST(Lidar, BrightSurfacesSendMoreBackAndFlatAnglesLess) {
  SmallWorld world;
  world.add("white", Box{{0.1, 4, 4}}, at(3, 0, 0), {{1, 1, 1}});
  world.add("black", Box{{0.1, 4, 4}}, at(-3, 0, 0), {{0.2F, 0.2F, 0.2F}});
  const auto rig = world.rig();
  double white = 0;
  double black = 0;
  double slanted = 0;
  for (const auto& p : sweep(*rig, few_columns(), at(0, 0, 0), at(0, 0, 0))) {
    const double azimuth = std::atan2(p.y, p.x);
    if (std::abs(azimuth) < 0.05) white = std::max<double>(white, p.intensity);
    if (std::abs(azimuth) > M_PI - 0.05) black = std::max<double>(black, p.intensity);
    if (std::abs(azimuth - 0.55) < 0.03) slanted = std::max<double>(slanted, p.intensity);
  }
  EXPECT_NEAR(white, 100, 3);
  EXPECT_LT(black, 10);
  EXPECT_LT(slanted, 0.9 * white);
}

TEST(Lidar, SameSeedSamePoints) {
  const auto first = room().rig(9);
  const auto second = room().rig(9);
  const LidarParams params;
  const auto a = sweep(*first, params, at(0, 0, 0), at(0.1, 0, 0));
  const auto b = sweep(*second, params, at(0, 0, 0), at(0.1, 0, 0));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i].x, b[i].x);
  EXPECT_NE(a.size(), 30000U);  // some are dropped
}

/// Points of the robot's own post, which stands 0.5 m before the sensor in the room, in the sensor's frame.
std::vector<LidarPoint> own_post(const Pose& begin, const Pose& end) {
  const auto robot = RobotModel::from_urdf(R"(<robot name="post"><link name="base"><visual>
    <origin xyz="0.5 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link></robot>)",
                                           "");
  if (!robot) throw std::runtime_error(robot.error().message);
  const auto rig = room().rig(1, *robot);
  auto snapshot = room().snapshot();
  snapshot.world_T_link = {end};
  rig->pose(snapshot);
  auto points = sweep(*rig, few_columns(3610), begin, end);
  points.erase(std::remove_if(points.begin(), points.end(), [](const auto& p) { return range_of(p) > 1; }),
               points.end());
  return points;
}

TEST(Lidar, SeesTheRobotMoveWithIt) {
  const auto still = own_post(at(0, 0, 0), at(0, 0, 0));
  ASSERT_GT(still.size(), 500U);
  for (const Pose& end : {at(0.1, 0, 0), at(-0.05, 0.1, 0), make_pose({0.1, 0.02, 0}, {0, 0, 0.15})}) {
    const auto moving = own_post(at(0, 0, 0), end);
    ASSERT_EQ(moving.size(), still.size());
    for (std::size_t i = 0; i < still.size(); ++i) {
      ASSERT_EQ(moving[i].ring, still[i].ring);
      ASSERT_NEAR(range_of(moving[i]), range_of(still[i]), 2e-3);  // poses between are those of a chord
    }
  }
}

TEST(Lidar, TheNextSweepOfARobotThatStandsSeesItStand) {
  const auto robot = RobotModel::from_urdf(R"(<robot name="post"><link name="base"><visual>
    <origin xyz="0.5 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></visual></link></robot>)",
                                           "");
  ASSERT_TRUE(robot) << robot.error().message;
  const auto rig = room().rig(1, *robot);
  auto snapshot = room().snapshot();
  snapshot.world_T_link = {at(0.1, 0, 0)};
  rig->pose(snapshot);
  (void)sweep(*rig, few_columns(), at(0, 0, 0), at(0.1, 0, 0));
  rig->pose(snapshot);
  for (const auto& p : sweep(*rig, few_columns(), at(0.1, 0, 0), at(0.1, 0, 0))) {
    if (std::abs(std::atan2(p.y, p.x)) > 0.02 || std::abs(p.z) > 0.03) continue;
    ASSERT_NEAR(p.x, 0.45, 1e-3);
  }
}

TEST(Range, NearestInTheCone) {
  SmallWorld world;
  world.add("post", Box{{0.2, 0.2, 2}}, at(2, 0.4, 0));
  const auto rig = world.rig();
  EXPECT_EQ(rig->range(at(0, 0, 0), 0.02, 5), std::numeric_limits<double>::infinity());
  const double found = rig->range(at(0, 0, 0), std::atan2(0.4, 2), 5);
  EXPECT_NEAR(found, 1.9 / std::cos(std::atan2(0.4, 2)), 1e-3);
  EXPECT_EQ(rig->range(at(0, 0, 0), std::atan2(0.4, 2), 1.5), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(rig->range(make_pose({2, 0, 0}, {0, 0, M_PI / 2}), 0, 5), 0.3, 1e-4);
}

}  // namespace
}  // namespace extperfc::simulate
