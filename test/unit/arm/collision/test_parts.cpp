// Convex parts: support points, distances, hulls, and covers of spheres.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/collision/convex_part.hpp"
#include "arm/collision/hull.hpp"
#include "arm/collision/sphere_cover.hpp"

namespace extperfc::arm {
namespace {

constexpr double kTiny = 1e-9;

std::vector<std::shared_ptr<const ConvexPart>> samples() {
  std::vector<std::shared_ptr<const ConvexPart>> parts;
  Shape shape;
  for (const Geometry& geometry :
       {Geometry{Box{{0.2, 0.1, 0.3}}}, Geometry{Box{{0.01, 0.0135, 0.1127}}},
        Geometry{Box{{0.4, 0.3, 0.02}}}, Geometry{Cylinder{0.06, 0.27}}, Geometry{Cylinder{0.15, 0.02}},
        Geometry{Cylinder{0.01, 0.5}}, Geometry{Sphere{0.1}}, Geometry{Cone{0.05, 0.2}},
        Geometry{Cone{0.2, 0.05}},
        Geometry{TriangleMesh{EXTPERFC_SOURCE_DIR "/urdf/meshes/upper_elbow_housing.stl", {1, 1, 1}}},
        Geometry{TriangleMesh{EXTPERFC_SOURCE_DIR "/urdf/meshes/torso_chest.stl", {1, -1, 0.5}}}}) {
    shape.geometry = geometry;
    parts.push_back(make_convex_part(shape).value());
  }
  return parts;
}

Eigen::Vector3d random_direction(Rng& rng) {
  return Eigen::Vector3d(rng.normal(0, 1), rng.normal(0, 1), rng.normal(0, 1)).normalized();
}

/// A point of the part: a mixture of support points, which spans all of it.
Eigen::Vector3d random_point(const ConvexPart& part, Rng& rng) {
  Eigen::Vector3d point = support(part, random_direction(rng));
  for (int i = 0; i < 3; ++i)
    if (rng.chance(0.5)) point += rng.uniform(0, 1) * (support(part, random_direction(rng)) - point);
  return point;
}

TEST(Parts, SupportIsFarthestAndInsideTheBounds) {
  Rng rng(1);
  for (const auto& part : samples())
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d direction = random_direction(rng), point = support(*part, direction);
      EXPECT_LE(point.norm(), bounding_radius(*part) + kTiny);
      EXPECT_LE((point.cwiseAbs() - part->half).maxCoeff(), kTiny);
      EXPECT_LE(distance_bound(*part, point), 1e-7);
      EXPECT_GE(direction.dot(point), direction.dot(random_point(*part, rng)) - kTiny);
    }
}

TEST(Parts, DistanceBoundIsABound) {
  Rng rng(2);
  for (const auto& part : samples())
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d outside = part->half.norm() * rng.uniform(0.5, 3) * random_direction(rng);
      EXPECT_LE(distance_bound(*part, outside), (outside - random_point(*part, rng)).norm() + 1e-7);
    }
}

TEST(Parts, TurnedBoxHoldsThePart) {
  Rng rng(3);
  for (const auto& part : samples())
    for (int i = 0; i < 100; ++i) {
      const Eigen::Matrix3d rotation = make_pose({0, 0, 0}, 3 * random_direction(rng)).linear();
      const Eigen::Vector3d half = rotated_half(*part, rotation);
      for (int k = 0; k < 10; ++k)
        EXPECT_LE(((rotation * random_point(*part, rng)).cwiseAbs() - half).maxCoeff(), 1e-7);
    }
}

TEST(Parts, HullHoldsItsPointsAndIsTight) {
  Rng rng(4);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(0.3 * random_direction(rng) + Eigen::Vector3d(1, 2, 3));
  const ConvexPart hull = convex_hull(points).value();
  for (const Plane& plane : hull.planes) {
    double highest = -1;
    for (const auto& point : points)
      highest = std::max(highest, plane.normal.dot(hull.body_T_part.inverse() * point) - plane.offset);
    EXPECT_NEAR(0, highest, 1e-12);
    EXPECT_GT(plane.offset, 0);  // the middle is inside
  }
  EXPECT_FALSE(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_FALSE(convex_hull({{0, 0, 0}, {1, 0, 0}}));
}

TEST(Cover, HoldsEveryPoint) {
  Rng rng(5);
  for (const auto& part : samples())
    for (const double excess : {0.005, 0.01, 0.03}) {
      const std::vector<Ball> cover = sphere_cover(*part, excess);
      for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d point = random_point(*part, rng);
        double nearest = 1;
        for (const Ball& ball : cover)
          nearest = std::min(nearest, (point - ball.centre).norm() - ball.radius);
        ASSERT_LE(nearest, 1e-7) << "part kind " << static_cast<int>(part->kind) << ", excess " << excess;
      }
    }
}

TEST(Cover, StandsOutNoFurtherThanAllowed) {
  Shape rod;
  rod.geometry = Cylinder{0.06, 0.27};
  for (const double excess : {0.005, 0.01, 0.03})
    for (const Ball& ball : sphere_cover(*make_convex_part(rod).value(), excess))
      EXPECT_LE(ball.radius - 0.06, excess + kTiny);
  Shape finger;
  finger.geometry = Box{{0.01, 0.0135, 0.1127}};
  for (const Ball& ball : sphere_cover(*make_convex_part(finger).value(), 0.01))
    EXPECT_LE(ball.radius, 0.005 + 0.01 + kTiny);
}

}  // namespace
}  // namespace extperfc::arm
