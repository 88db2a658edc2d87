#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "mapping/near_mask.hpp"
#include "mapping/surface_map.hpp"

namespace extperfc::mapping {
namespace {

ScanPoints points_of(const std::vector<SurfacePoint>& surface) {
  ScanPoints points;
  points.surface = surface;
  return points;
}

std::size_t count(const SurfaceMap& map) {
  std::size_t surfaces = 0;
  map.visit([&](const SurfaceMap::Surface&) { ++surfaces; });
  return surfaces;
}

TEST(SurfaceMap, MeanAndNormalOfACell) {
  SurfaceMap map;
  EXPECT_TRUE(map.empty());
  const Eigen::Vector2f a(std::cos(0.2F), std::sin(0.2F));
  const Eigen::Vector2f b(std::cos(-0.2F), std::sin(-0.2F));
  map.add(points_of({{{0.01F, 0.02F}, a}, {{0.05F, 0.02F}, b}, {{0.03F, 0.05F}, {1, 0}}}), {});
  EXPECT_FALSE(map.empty());
  ASSERT_EQ(count(map), 1U);
  map.visit([](const SurfaceMap::Surface& surface) {
    EXPECT_NEAR(surface.mean.x(), 0.03, 1e-6);
    EXPECT_NEAR(surface.mean.y(), 0.03, 1e-6);
    EXPECT_NEAR(surface.normal.x(), 1, 1e-2);
    EXPECT_NEAR(surface.normal.y(), 0, 1e-2);
    EXPECT_NEAR(surface.normal.norm(), 1, 1e-6);
    EXPECT_EQ(surface.weight, 3);
  });
  map.clear();
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.nearest({0.03F, 0.03F}, {0, 0}, 3), nullptr);
}

TEST(SurfaceMap, MeanOfManyIsTheirMean) {
  Rng rng(1);
  SurfaceMap map;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  constexpr int kPoints = 50;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector2d p(rng.uniform(-0.16, -0.08), rng.uniform(0, 0.08));
    sum += p;
    map.add(points_of({{p.cast<float>(), {0, 1}}}), {});
  }
  const auto* surface = map.nearest({-0.12F, 0.04F}, {0, 1}, 2);
  ASSERT_NE(surface, nullptr);
  EXPECT_LT((surface->mean.cast<double>() - sum / kPoints).norm(), 1e-5);
}

TEST(SurfaceMap, PosesMoveAndTurnPointsAndNormals) {
  SurfaceMap map;
  map.add(points_of({{{1, 0}, {-1, 0}}}), {2, 3, M_PI / 2});
  const auto* surface = map.nearest({2, 4}, {0, -1}, 1);
  ASSERT_NE(surface, nullptr);
  EXPECT_NEAR(surface->mean.x(), 2, 1e-5);
  EXPECT_NEAR(surface->mean.y(), 4, 1e-5);
  EXPECT_NEAR(surface->normal.y(), -1, 1e-5);
  EXPECT_EQ(map.nearest({2, 4}, {0, 1}, 1), nullptr) << "the other side was not seen";
  EXPECT_NE(map.nearest({2, 4}, {0, 0}, 1), nullptr) << "an unknown direction goes with any";
}

TEST(SurfaceMap, SidesOfAThinWallStayApart) {
  for (const float thickness_m : {0.03F, 0.1F, 0.15F}) {
    SCOPED_TRACE(thickness_m);
    SurfaceMap map;
    std::vector<SurfacePoint> near_side;
    std::vector<SurfacePoint> far_side;
    for (int i = 0; i < 40; ++i) {
      const float x = 0.03F * static_cast<float>(i);
      near_side.push_back({{x, 0.03F}, {0, -1}});
      far_side.push_back({{x, 0.03F + thickness_m}, {0, 1}});
    }
    for (int pass = 0; pass < 3; ++pass) {
      map.add(points_of(near_side), {});
      map.add(points_of(far_side), {});
    }
    for (float x = 0.1F; x < 1.1F; x += 0.05F) {
      const auto* near_surface = map.nearest({x, 0.03F}, {0, -1}, 3);
      const auto* far_surface = map.nearest({x, 0.03F + thickness_m}, {0, 1}, 3);
      if (near_surface) {
        EXPECT_NEAR(near_surface->mean.y(), 0.03, 0.002) << x;
        EXPECT_LT(near_surface->normal.y(), -0.99F);
      }
      if (far_surface) {
        EXPECT_NEAR(far_surface->mean.y(), 0.03 + static_cast<double>(thickness_m), 0.002) << x;
        EXPECT_GT(far_surface->normal.y(), 0.99F);
      }
      if (thickness_m > SurfaceMap::kCellM) {
        EXPECT_TRUE(near_surface && far_surface) << x;
      } else {
        EXPECT_TRUE(near_surface || far_surface) << x;
      }
    }
  }
}

TEST(SurfaceMap, ASideThatIsSeenMoreTakesOver) {
  SurfaceMap map;
  const auto one = points_of({{{0.04F, 0.04F}, {0, 1}}});
  const auto other = points_of({{{0.04F, 0.02F}, {0, -1}}});
  for (int i = 0; i < 3; ++i) map.add(one, {});
  map.add(other, {});
  EXPECT_NE(map.nearest({0.04F, 0.04F}, {0, 1}, 1), nullptr);
  for (int i = 0; i < 10; ++i) map.add(other, {});
  EXPECT_EQ(map.nearest({0.04F, 0.04F}, {0, 1}, 1), nullptr);
  const auto* surface = map.nearest({0.04F, 0.04F}, {0, -1}, 1);
  ASSERT_NE(surface, nullptr);
  EXPECT_NEAR(surface->mean.y(), 0.02, 1e-6) << "nothing of the other side is left";
}

TEST(SurfaceMap, NearestIsTheNearestWithinReach) {
  Rng rng(2);
  SurfaceMap map;
  for (int i = 0; i < 150; ++i) {
    const double angle = rng.uniform(-M_PI, M_PI);
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d at(rng.uniform(-2, 2), rng.uniform(-2, 2));
    map.add(points_of(
                {{at.cast<float>(), rng.chance(0.2) ? Eigen::Vector2f(0, 0) : normal.cast<float>().eval()}}),
            {});
  }
  int found = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2f at(static_cast<float>(rng.uniform(-2.5, 2.5)),
                             static_cast<float>(rng.uniform(-2.5, 2.5)));
    const auto angle = static_cast<float>(rng.uniform(-M_PI, M_PI));
    const Eigen::Vector2f normal =
        i % 5 == 0 ? Eigen::Vector2f(0, 0) : Eigen::Vector2f(std::cos(angle), std::sin(angle));
    const int reach = rng.integer(1, 6);
    float nearest = SurfaceMap::kCellM * static_cast<float>(reach);
    const SurfaceMap::Surface* expected = nullptr;
    map.visit([&](const SurfaceMap::Surface& surface) {
      const bool unknown = surface.normal.norm() == 0 || normal.norm() == 0;
      if (!unknown && surface.normal.dot(normal) <= 0.6F) return;
      const float away = (surface.mean - at).norm();
      if (away >= nearest) return;
      nearest = away;
      expected = &surface;
    });
    EXPECT_EQ(map.nearest(at, normal, reach), expected);
    if (expected) ++found;
  }
  EXPECT_GT(found, 100);
}

TEST(SurfaceMap, AboutAPointIsAllThatIsNearIt) {
  Rng rng(3);
  SurfaceMap map;
  for (int i = 0; i < 400; ++i)
    map.add(points_of(
                {{{static_cast<float>(rng.uniform(-6, 6)), static_cast<float>(rng.uniform(-6, 6))}, {0, 0}}}),
            {});
  std::size_t all = 0;
  map.visit([&](const SurfaceMap::Surface&) { ++all; });
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2f at(static_cast<float>(rng.uniform(-9, 9)), static_cast<float>(rng.uniform(-9, 9)));
    const auto radius = static_cast<float>(rng.uniform(0, 3));
    std::set<const SurfaceMap::Surface*> visited;
    map.visit_about(at, radius, [&](const SurfaceMap::Surface& surface) { visited.insert(&surface); });
    map.visit([&](const SurfaceMap::Surface& surface) {
      if ((surface.mean - at).norm() <= radius) {
        EXPECT_EQ(visited.count(&surface), 1U);
      }
    });
    EXPECT_LT(visited.size(), all);
  }
}

TEST(NearMask, TheCellOfASurfaceAndThoseAroundIt) {
  SurfaceMap map;
  EXPECT_FALSE(NearMask(map).at({0, 0}));
  map.add(points_of({{{0.04F, 0.04F}, {0, 1}}}), {});
  const NearMask mask(map);
  for (const float x : {-0.07F, 0.04F, 0.15F})
    for (const float y : {-0.07F, 0.04F, 0.15F}) EXPECT_TRUE(mask.at({x, y}));
  EXPECT_FALSE(mask.at({0.17F, 0.04F}));
  EXPECT_FALSE(mask.at({0.04F, -0.09F}));
}

TEST(NearMask, SaysWhatTheSurfacesSay) {
  Rng rng(5);
  std::vector<SurfacePoint> seen;
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<float>(rng.uniform(-9, 14));
    const auto y = static_cast<float>(rng.uniform(-30, 2));
    seen.push_back({{x, y}, {0, 1}});
  }
  SurfaceMap map;
  map.add(points_of(seen), {});
  const NearMask mask(map);
  int near_surfaces = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2f at(static_cast<float>(rng.uniform(-40, 40)),
                             static_cast<float>(rng.uniform(-40, 40)));
    const bool expected = std::any_of(seen.begin(), seen.end(), [&](const SurfacePoint& point) {
      const auto away = [](float a, float b) {
        return std::abs(SurfaceMap::cell_index(a) - SurfaceMap::cell_index(b));
      };
      return away(at.x(), point.position.x()) <= 1 && away(at.y(), point.position.y()) <= 1;
    });
    ASSERT_EQ(mask.at(at), expected);
    if (expected) ++near_surfaces;
  }
  EXPECT_GT(near_surfaces, 50);
}

TEST(SurfaceMap, WideCoordinates) {
  SurfaceMap map;
  const std::vector<Eigen::Vector2f> places{{0, 0}, {300, 2}, {-250, -310}, {5, 280}, {-0.01F, -0.01F}};
  for (const auto& place : places) map.add(points_of({{place, {1, 0}}}), {});
  for (const auto& place : places) {
    const auto* surface = map.nearest(place, {1, 0}, 1);
    ASSERT_NE(surface, nullptr) << place.transpose();
    EXPECT_LT((surface->mean - place).norm(), 1e-3F);
  }
  EXPECT_EQ(count(map), places.size()) << "a cell each, however wide the way between them";
}

TEST(SurfaceMap, WhatCannotBeIsIgnored) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  SurfaceMap map;
  map.add(points_of({{{kNan, 0}, {0, 0}}, {{0, kInf}, {0, 0}}, {{1e9F, 0}, {0, 0}}, {{0, -1e30F}, {0, 0}}}),
          {});
  map.add(points_of({{{1, 0}, {0, 0}}}), {1e30, 0, 0});
  EXPECT_TRUE(map.empty());
  map.add(points_of({{{1, 0}, {0, 0}}}), {});
  EXPECT_EQ(map.nearest({500, -500}, {0, 0}, 3), nullptr);
  EXPECT_EQ(count(map), 1U);
}

}  // namespace
}  // namespace extperfc::mapping
