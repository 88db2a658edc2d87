// How low and how high shapes reach.
#include <cmath>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "extperfc/world/shape_extent.hpp"

namespace extperfc {
namespace {

constexpr double kPi = 3.14159265358979323846;

void expect(const Geometry& geometry, const Pose& pose, double low_m, double high_m) {
  const auto extent = vertical_extent(geometry, pose);
  EXPECT_NEAR(extent.low_m, low_m, 1e-12);
  EXPECT_NEAR(extent.high_m, high_m, 1e-12);
}

TEST(ShapeExtent, StandingShapes) {
  const Pose pose = make_pose({5, -3, 1}, {0, 0, 0.7});
  expect(Box{{0.2, 0.4, 0.6}}, pose, 0.7, 1.3);
  expect(Sphere{0.25}, pose, 0.75, 1.25);
  expect(Cylinder{0.1, 0.5}, pose, 0.75, 1.25);
  expect(Cone{0.1, 0.5}, pose, 0.75, 1.25);
}

TEST(ShapeExtent, TiltedShapes) {
  const double slant = std::sqrt(0.5);
  const Pose pose = make_pose({0, 0, 1}, {kPi / 4, 0, 0});
  expect(Box{{0.2, 0.4, 0.6}}, pose, 1 - slant * 0.5, 1 + slant * 0.5);
  expect(Cylinder{0.1, 0.5}, pose, 1 - slant * 0.35, 1 + slant * 0.35);
  // The tip of a slim cone is the highest point; the rim of a flat one rises above it.
  expect(Cone{0.1, 0.5}, pose, 1 - slant * 0.35, 1 + slant * 0.25);
  expect(Cone{0.6, 0.2}, pose, 1 - slant * 0.7, 1 + slant * 0.5);
  // Upside down the tip is the lowest point.
  expect(Cone{0.1, 0.5}, make_pose({0, 0, 1}, {3 * kPi / 4, 0, 0}), 1 - slant * 0.25, 1 + slant * 0.35);
}

TEST(ShapeExtent, MeshesByTheirCorners) {
  TriangleMesh mesh;
  mesh.scale = {1, 1, 2};
  expect(mesh, make_pose({0, 0, 1}), 0, 2);
  mesh.triangles = std::make_shared<std::vector<Triangle>>(
      1, Triangle{Eigen::Vector3f{0, 0, 0}, Eigen::Vector3f{1, 0, 0.25F}, Eigen::Vector3f{0, 1, -0.5F}});
  expect(mesh, make_pose({0, 0, 1}), 0, 1.5);
}

TEST(ShapeExtent, BodiesOfSeveralShapes) {
  Shape low, high;
  low.geometry = high.geometry = Sphere{0.1};
  low.body_T_shape = make_pose({0, 0, -1});
  high.body_T_shape = make_pose({0, 0, 1});
  const auto extent = vertical_extent({low, high}, make_pose({0, 0, 3}, {kPi, 0, 0}));
  EXPECT_NEAR(extent.low_m, 1.9, 1e-12);
  EXPECT_NEAR(extent.high_m, 4.1, 1e-12);
  EXPECT_EQ(vertical_extent(std::vector<Shape>{}, Pose::Identity()).low_m,
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace extperfc
