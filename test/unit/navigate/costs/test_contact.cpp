// Contacts: every cell that a footprint overlaps and no other, judged by Bullet and by clipped areas.
#include <algorithm>
#include <cmath>
#include <limits>

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>
#include <gtest/gtest.h>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/footprint.hpp"

#include "test/unit/navigate/costs/polygon_oracle.hpp"

namespace extperfc::navigate {
namespace {

using Eigen::Vector2d;
using Corners = std::vector<Vector2d>;

const Corners kSquare{{-0.4, -0.4}, {0.4, -0.4}, {0.4, 0.4}, {-0.4, 0.4}};
const Corners kChassis{{-0.4064, -0.3937}, {0.4064, -0.3937}, {0.4064, 0.3937}, {-0.4064, 0.3937}};

constexpr double kBulletError = 1e-4;  // of GJK where prisms just overlap [m]

CostGrid free_grid(int width, int height) {
  return make_cost_grid(width, height, 0.05, {-1, -0.5}, kFreeCost);
}

Corners random_corners(Rng& rng, bool convex) {
  const int n = rng.integer(3, 12);
  Corners corners;
  const double radius = rng.uniform(0.1, 0.6);
  for (int i = 0; i < n; ++i) {
    const double angle = kTwoPi * (i + rng.uniform(-0.3, 0.3)) / n;
    corners.emplace_back((convex ? radius : rng.uniform(0.1, 0.6)) *
                         Vector2d(std::cos(angle), std::sin(angle)));
  }
  return corners;
}

/// Signed distance of a cell's square and a convex polygon [m], as prisms of 1 m.
double bullet_distance_m(const CostGrid& grid, Cell cell, const Corners& polygon) {
  const Vector2d middle = grid.middle_of(cell);
  btBoxShape box({grid.resolution_m / 2, grid.resolution_m / 2, 0.5});
  box.setMargin(0);
  btConvexHullShape hull;
  hull.setMargin(0);
  for (const auto& corner : polygon)
    for (const double z : {-0.5, 0.5})
      hull.addPoint({corner.x() - middle.x(), corner.y() - middle.y(), z}, false);
  hull.recalcLocalAabb();
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;
  btGjkPairDetector detector(&box, &hull, &simplex, &depth);
  btGjkPairDetector::ClosestPointInput input;
  input.m_transformA.setIdentity();
  input.m_transformB.setIdentity();
  btPointCollector result;
  detector.getClosestPoints(input, result, nullptr);
  return result.m_hasResult ? result.m_distance : 1;
}

/// Whether a footprint touches one lethal cell of a free grid.
bool touches(CostGrid& grid, const Footprint& footprint, const Pose2& pose, Cell cell) {
  grid.at(cell) = kLethalCost;
  const Contact found = contact(grid, footprint, pose);
  grid.at(cell) = kFreeCost;
  EXPECT_NE(found, Contact::kUnknown);
  return found == Contact::kObstacle;
}

TEST(Contact, ConvexFootprintsAsBulletHasThem) {
  Rng rng(11);
  CostGrid grid = free_grid(40, 40);
  int touched = 0, apart = 0, narrow = 0;
  for (int round = 0; round < 400; ++round) {
    const auto footprint = Footprint::make(random_corners(rng, true));
    if (!footprint) continue;
    const Pose2 pose{rng.uniform(-0.3, 0.3), rng.uniform(0.2, 0.8), rng.uniform(-kPi, kPi)};
    const Corners placed = test::moved(footprint->corners_m(), pose);
    for (int i = 0; i < 80; ++i) {
      const Cell cell{rng.integer(0, 39), rng.integer(0, 39)};
      const double distance_m = bullet_distance_m(grid, cell, placed);
      const bool touch = touches(grid, *footprint, pose, cell);
      if (std::abs(distance_m) < kBulletError)
        ++narrow;
      else
        ASSERT_EQ(touch, distance_m < 0) << "round " << round << ", " << distance_m << " m";
      (touch ? touched : apart)++;
    }
  }
  EXPECT_GT(touched, 2000);
  EXPECT_GT(apart, 2000);
  EXPECT_LT(narrow, 50);
}

TEST(Contact, AnySimpleFootprintByClippedArea) {
  Rng rng(12);
  CostGrid grid = free_grid(40, 40);
  int touched = 0, narrow = 0;
  for (int round = 0; round < 300; ++round) {
    const auto footprint = Footprint::make(random_corners(rng, rng.chance(0.3)));
    if (!footprint) continue;
    const Pose2 pose{rng.uniform(-0.3, 0.3), rng.uniform(0.2, 0.8), rng.uniform(-kPi, kPi)};
    const Corners placed = test::moved(footprint->corners_m(), pose);
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 40; ++column) {
        const double area_m2 = test::overlap_m2(grid, {column, row}, placed);
        if (area_m2 > 0 && area_m2 < 1e-8) {
          ++narrow;
          continue;
        }
        ASSERT_EQ(touches(grid, *footprint, pose, {column, row}), area_m2 > 1e-12)
            << "round " << round << ", cell " << column << ' ' << row << ", area " << area_m2;
        if (area_m2 > 0) ++touched;
      }
    }
  }
  EXPECT_GT(touched, 20000);
  EXPECT_LT(narrow, 100);
}

TEST(Contact, SidesAlongCellsAreNoContact) {
  CostGrid grid = free_grid(60, 60);
  const auto footprint = Footprint::make(kSquare).value();
  for (const double quarter : {0.0, 0.5, 1.0, -0.5}) {
    const Pose2 pose{0.5, 0.75, quarter * kPi};
    int count = 0;
    for (int row = 0; row < 60; ++row)
      for (int column = 0; column < 60; ++column)
        count += touches(grid, footprint, pose, {column, row}) ? 1 : 0;
    EXPECT_EQ(count, 16 * 16);
  }
}

TEST(Contact, ObstacleCountsMoreThanUnknownMoreThanFree) {
  CostGrid grid = free_grid(40, 40);
  const auto footprint = Footprint::make(kChassis).value();
  const Pose2 pose{0, 0.5, 0.3};
  EXPECT_EQ(contact(grid, footprint, pose), Contact::kFree);
  grid.at({18, 22}) = kUnknownCost;
  EXPECT_EQ(contact(grid, footprint, pose), Contact::kUnknown);
  grid.at({22, 18}) = kLethalCost;
  EXPECT_EQ(contact(grid, footprint, pose), Contact::kObstacle);
  grid.at({22, 18}) = kInscribedCost;
  EXPECT_EQ(contact(grid, footprint, pose), Contact::kUnknown);
  grid.at({19, 22}) = kLethalCost;  // in the row of the unknown cell
  EXPECT_EQ(contact(grid, footprint, pose), Contact::kObstacle);
}

TEST(Contact, LeavingTheGridIsUnknown) {
  CostGrid grid = free_grid(40, 40);  // x from -1 to 1, y from -0.5 to 1.5
  const auto footprint = Footprint::make(kSquare).value();
  EXPECT_EQ(contact(grid, footprint, {-0.6, 0, 0}), Contact::kFree);
  EXPECT_EQ(contact(grid, footprint, {-0.61, 0, 0}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {0.61, 0, 0}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {0, -0.11, 0}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {0, 1.11, 0}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {50, 50, 1}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {1e300, -1e300, 1}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {std::numeric_limits<double>::max(), 0, 1}), Contact::kUnknown);
  EXPECT_EQ(contact(grid, footprint, {std::numeric_limits<double>::quiet_NaN(), 0, 0}), Contact::kUnknown);
  EXPECT_EQ(contact({}, footprint, {0, 0, 0}), Contact::kUnknown);
  grid.at({0, 10}) = kLethalCost;  // partly outside, and an obstacle inside
  EXPECT_EQ(contact(grid, footprint, {-0.9, 0, 0}), Contact::kObstacle);
  EXPECT_EQ(contact(grid, footprint, {-1.2, 0, 0}), Contact::kObstacle);  // the base itself is outside
}

TEST(Contact, LargerThanTheGrid) {
  CostGrid grid = make_cost_grid(3, 2, 0.05, {0, 0}, kFreeCost);
  const auto footprint = Footprint::make({{-5, -5}, {5, -5}, {5, 5}, {-5, 5}}).value();
  EXPECT_EQ(contact(grid, footprint, {0.1, 0, 0.4}), Contact::kUnknown);
  grid.at({2, 1}) = kLethalCost;
  EXPECT_EQ(contact(grid, footprint, {0.1, 0, 0.4}), Contact::kObstacle);
}

/// costmap_2d's inflation, cell by cell.
void inflate(CostGrid& grid, const Inflation& inflation) {
  const CostGrid before = grid;
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column)
      for (int r = 0; r < grid.height; ++r)
        for (int c = 0; c < grid.width; ++c)
          if (before.at({c, r}) == kLethalCost)
            grid.at({column, row}) =
                std::max(grid.at({column, row}),
                         inflation.cost_at(std::hypot(column - c, row - r) * grid.resolution_m));
  grid.inflation = inflation;
  grid.may_hold_unknown = false;
}

TEST(Contact, TheCentresCostConcludesNothingWrong) {
  Rng rng(13);
  const auto footprint = Footprint::make(kChassis).value();
  int free = 0, by_centre = 0;
  for (int round = 0; round < 12; ++round) {
    CostGrid plain = free_grid(50, 50);
    for (int i = 0; i < 4; ++i) plain.at({rng.integer(0, 49), rng.integer(0, 49)}) = kLethalCost;
    CostGrid inflated = plain;
    const double scaling = rng.uniform(1, 10);
    inflate(inflated, {0.3937, rng.uniform(0.4, 1.1), scaling});
    for (int i = 0; i < 2000; ++i) {
      const Pose2 pose{rng.uniform(-1, 1.5), rng.uniform(-0.5, 2), rng.uniform(-kPi, kPi)};
      const Contact exact = contact(plain, footprint, pose);
      ASSERT_EQ(contact(inflated, footprint, pose), exact) << "round " << round;
      free += exact == Contact::kFree ? 1 : 0;
      const auto cell = inflated.cell_of({pose.x, pose.y});
      by_centre += cell && inflated.at(*cell) < inflated.inflation.cost_at(0.64) ? 1 : 0;
    }
  }
  EXPECT_GT(free, 2000);
  EXPECT_GT(by_centre, 1000);
}

TEST(ContactAlong, NoThinWallIsJumped) {
  CostGrid grid = free_grid(100, 60);
  for (int row = 0; row < 60; ++row) grid.at({50, row}) = kLethalCost;
  const auto footprint = Footprint::circle(0.01);
  EXPECT_EQ(contact_along(grid, footprint, {1, 1, 0}, {3, 1.2, 0}), Contact::kObstacle);
  EXPECT_EQ(contact_along(grid, footprint, {1, 1, 0}, {1.4, 1.2, 3}), Contact::kFree);
}

TEST(ContactAlong, RotationIsTheShortOne) {
  CostGrid grid = free_grid(60, 60);
  const auto bar = Footprint::make({{-0.05, -0.05}, {0.8, -0.05}, {0.8, 0.05}, {-0.05, 0.05}}).value();
  grid.at({40, 30}) = kLethalCost;  // east of the base
  const Pose2 from{0.5, 1.025, 2.5};
  EXPECT_EQ(contact_along(grid, bar, from, {0.5, 1.025, -2.5}), Contact::kFree);
  EXPECT_EQ(contact_along(grid, bar, {0.5, 1.025, 0.5}, {0.5, 1.025, -0.5}), Contact::kObstacle);
}

TEST(ContactAlong, TheFirstContactDecides) {
  CostGrid grid = free_grid(60, 60);
  grid.at({25, 30}) = kUnknownCost;
  grid.at({40, 30}) = kLethalCost;
  const auto footprint = Footprint::circle(0.06);
  const Pose2 west{-0.3, 1.02, 0};
  const Pose2 east{1.5, 1.02, 0};
  EXPECT_EQ(contact_along(grid, footprint, west, east), Contact::kUnknown);
  EXPECT_EQ(contact_along(grid, footprint, east, west), Contact::kObstacle);
  EXPECT_EQ(contact_along(grid, footprint, west, west), Contact::kFree);
  EXPECT_EQ(contact_along(grid, footprint, west, {std::nan(""), 0, 0}), Contact::kUnknown);
}

}  // namespace
}  // namespace extperfc::navigate
