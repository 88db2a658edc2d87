// Lines through solids, against points of the solids.
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/grasping/chord.hpp"

namespace extperfc::arm {
namespace {

std::vector<std::shared_ptr<const ConvexPart>> samples() {
  std::vector<std::shared_ptr<const ConvexPart>> parts;
  for (const Geometry& geometry :
       {Geometry{Box{{0.2, 0.1, 0.3}}}, Geometry{Cylinder{0.06, 0.27}}, Geometry{Cylinder{0.15, 0.02}},
        Geometry{Sphere{0.1}}, Geometry{Cone{0.05, 0.2}}, Geometry{Cone{0.2, 0.05}}}) {
    Shape shape;
    shape.geometry = geometry;
    parts.push_back(make_convex_part(shape).value());
  }
  return parts;
}

Eigen::Vector3d random_vector(Rng& rng, double half) {
  return {rng.uniform(-half, half), rng.uniform(-half, half), rng.uniform(-half, half)};
}

/// Exact for all kinds but hulls: not positive inside, positive outside.
bool inside(const ConvexPart& part, const Eigen::Vector3d& point) {
  return distance_bound(part, point) <= 0;
}

TEST(Chord, IsWhereTheLineIsInside) {
  constexpr double kTiny = 1e-7;
  Rng rng(7);
  int hits = 0;
  for (const auto& part : samples())
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d point = random_vector(rng, 0.2);
      const Eigen::Vector3d direction =
          i % 10 == 0 ? Eigen::Vector3d::Unit(i / 10 % 3) : random_vector(rng, 1).normalized();
      const auto found = chord(*part, point, direction);
      for (int k = 0; k < 20; ++k) {
        const double t = rng.uniform(-0.5, 0.5);
        const bool within = inside(*part, point + t * direction);
        if (!found) {
          EXPECT_FALSE(within);
        } else if (t < found->from - kTiny || t > found->to + kTiny) {
          EXPECT_FALSE(within);
        } else if (t > found->from + kTiny && t < found->to - kTiny) {
          EXPECT_TRUE(within);
        }
      }
      hits += found ? 1 : 0;
    }
  EXPECT_GT(hits, 3000);
}

TEST(Chord, NormalsPointOut) {
  Rng rng(8);
  for (const auto& part : samples())
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d direction = random_vector(rng, 1).normalized();
      const Eigen::Vector3d start(0, 0, -part->half.z() / 2);  // inside of all of them
      const auto through = chord(*part, start, direction);
      ASSERT_TRUE(through);
      const Eigen::Vector3d surface = start + through->to * direction;
      const Eigen::Vector3d normal = outward_normal(*part, surface);
      EXPECT_NEAR(normal.norm(), 1, 1e-12);
      EXPECT_FALSE(inside(*part, surface + 1e-6 * normal));
      EXPECT_TRUE(inside(*part, surface - 1e-6 * normal));
    }
}

}  // namespace
}  // namespace extperfc::arm
