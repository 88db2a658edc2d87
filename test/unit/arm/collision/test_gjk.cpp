// Distances of convex parts: every gap that there is gets proven, and no gap that there is not.
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/collision/convex_part.hpp"
#include "arm/collision/gjk.hpp"
#include "arm/collision/hull.hpp"

namespace extperfc::arm {
namespace {

using Eigen::Vector3d;

Vector3d random_vector(Rng& rng, double half) {
  return {rng.uniform(-half, half), rng.uniform(-half, half), rng.uniform(-half, half)};
}

ConvexPart made_of(const Geometry& geometry) {
  Shape shape;
  shape.geometry = geometry;
  return *make_convex_part(shape).value();
}

ConvexPart random_part(PartKind kind, Rng& rng) {
  const auto size = [&] { return rng.uniform(0.01, 0.3); };
  switch (kind) {
    case PartKind::kBox:
      return made_of(Box{{size(), size(), size()}});
    case PartKind::kCylinder:
      return made_of(Cylinder{size(), size()});
    case PartKind::kSphere:
      return made_of(Sphere{size()});
    case PartKind::kCone:
      return made_of(Cone{size(), size()});
    case PartKind::kHull:
      break;
  }
  std::vector<Vector3d> corners;
  for (int i = 0; i < 20; ++i) corners.push_back(random_vector(rng, 0.15));
  return convex_hull(corners).value();
}

struct Placed {
  ConvexPart part;
  Pose pose;
  [[nodiscard]] Vector3d farthest(const Vector3d& direction) const {
    return pose * support(part, pose.linear().transpose() * direction);
  }
};

Placed random_placed(PartKind kind, Rng& rng) {
  return {random_part(kind, rng), make_pose(random_vector(rng, 1), random_vector(rng, 3))};
}

Proximity between(const Placed& a, const Placed& b) {
  const auto lowest = [&](const Vector3d& d) { return Vector3d(a.farthest(-d) - b.farthest(d)); };
  return gjk(lowest, a.pose.translation() - b.pose.translation(), 0);
}

void for_every_pair_of_kinds(const std::function<void(PartKind, PartKind)>& use) {
  for (int a = 0; a <= static_cast<int>(PartKind::kHull); ++a)
    for (int b = 0; b <= a; ++b) use(static_cast<PartKind>(a), static_cast<PartKind>(b));
}

TEST(Gjk, ProvesEveryGapToATenthOfAMicrometre) {
  Rng rng(1);
  for_every_pair_of_kinds([&](PartKind kind_a, PartKind kind_b) {
    for (int i = 0; i < 100; ++i)
      for (const double gap : {1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0}) {
        Placed a = random_placed(kind_a, rng);
        const Placed b = random_placed(kind_b, rng);
        // Their farthest points along a direction are `gap` apart along it: then so are they.
        const Vector3d direction = random_vector(rng, 1).normalized();
        a.pose.translation() += b.farthest(direction) + gap * direction - a.farthest(-direction);
        const Proximity found = between(a, b);
        EXPECT_GT(found.at_least_m, gap - 2 * kGjkTolerance_m)
            << "kinds " << static_cast<int>(kind_a) << " " << static_cast<int>(kind_b) << ", gap " << gap;
        EXPECT_LE(found.at_least_m, gap + 1e-12);
        EXPECT_GE(found.at_most_m, gap - 1e-12);
      }
  });
}

TEST(Gjk, WhatSharesAPointIsNeverApart) {
  Rng rng(2);
  for_every_pair_of_kinds([&](PartKind kind_a, PartKind kind_b) {
    for (int i = 0; i < 200; ++i) {
      Placed a = random_placed(kind_a, rng);
      const Placed b = random_placed(kind_b, rng);
      // A point of the surface of one stands inside the other, or on its surface.
      const Vector3d inside = b.pose.translation() +
                              rng.uniform(0, 1) * (b.farthest(random_vector(rng, 1)) - b.pose.translation());
      a.pose.translation() += inside - a.farthest(random_vector(rng, 1));
      EXPECT_LE(between(a, b).at_least_m, 1e-12)
          << "kinds " << static_cast<int>(kind_a) << " " << static_cast<int>(kind_b);
    }
  });
}

TEST(Gjk, PartsInOnePlaceTouch) {
  Rng rng(3);
  for_every_pair_of_kinds([&](PartKind kind_a, PartKind kind_b) {
    Placed a = random_placed(kind_a, rng), b = random_placed(kind_b, rng);
    a.pose.translation() = b.pose.translation();
    const auto lowest = [&](const Vector3d& d) { return Vector3d(a.farthest(-d) - b.farthest(d)); };
    EXPECT_LE(gjk(lowest, Vector3d::UnitZ(), 0).at_least_m, 0);
  });
}

}  // namespace
}  // namespace extperfc::arm
