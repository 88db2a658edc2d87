// Whose points are: against a look at every shape.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "arm/perception/shape_mask.hpp"

namespace extperfc::arm {
namespace {

const VoxelGrid kGrid{{-0.5, -0.5, 0}, 0.025, {40, 40, 40}};

Geometry geometry_of(int kind, double size) {
  switch (kind) {
    case 0:
      return Box{{size, size / 2, size / 3}};
    case 1:
      return Cylinder{size / 3, size};
    case 2:
      return Cone{size / 3, size};
    default:
      return TriangleMesh{EXTPERFC_SOURCE_DIR "/urdf/meshes/upper_elbow_housing.stl", {1, 1, 1}};
  }
}

std::vector<MaskPart> random_parts(Rng& rng) {
  std::vector<MaskPart> parts;
  for (int i = 0; i < 12; ++i) {
    Shape shape;
    shape.geometry = geometry_of(i % 4, rng.uniform(0.05, 0.3));
    const Pose pose = make_pose({rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6), rng.uniform(-0.1, 1.1)},
                                {rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-3, 3)});
    const auto part = make_convex_part(shape).value();
    const bool robot = rng.chance(0.5);
    parts.push_back(
        {part, pose * part->body_T_part, robot ? 0.03 : 0.015, robot ? Owner::kRobot : Owner::kObject});
  }
  return parts;
}

/// Distance bound less padding of the nearest shape.
double nearest(const std::vector<MaskPart>& parts, const Eigen::Vector3d& point) {
  double smallest = 1e9;
  for (const MaskPart& own : parts)
    smallest =
        std::min(smallest, distance_bound(*own.part, own.root_T_part.inverse() * point) - own.padding_m);
  return smallest;
}

TEST(ShapeMask, KnowsEveryPointWithinThePaddingAndNoOther) {
  constexpr double kRounding = 1e-5;  // of single precision
  Rng rng(6);
  ShapeMask mask(kGrid);
  int within = 0, outside = 0;
  for (int round = 0; round < 5; ++round) {  // one mask for all: nothing is left of the round before
    const auto parts = random_parts(rng);
    mask.set(parts);
    for (int i = 0; i < 20000; ++i) {
      const Eigen::Vector3d point(rng.uniform(-0.499, 0.499), rng.uniform(-0.499, 0.499),
                                  rng.uniform(0.001, 0.999));
      const double gap = nearest(parts, point);
      if (std::abs(gap) < kRounding) continue;
      const Eigen::Vector3i cell = ((point - kGrid.low) / kGrid.edge).cast<int>();
      const Owner owner = mask.owner(kGrid.index(cell.x(), cell.y(), cell.z()), point.cast<float>());
      EXPECT_EQ(owner != Owner::kNone, gap < 0);
      ++(gap < 0 ? within : outside);
    }
  }
  EXPECT_GT(within, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(ShapeMask, CoversWhatTheRobotTouches) {
  ShapeMask mask(kGrid);
  Shape shape;
  shape.geometry = Sphere{0.1};
  const auto part = make_convex_part(shape).value();
  mask.set({{part, make_pose({0, 0, 0.5}), 0.03, Owner::kRobot}});
  for (int i = 0; i < static_cast<int>(kGrid.size()); ++i) {
    const double gap = (kGrid.centre(kGrid.cell(i)) - Eigen::Vector3d(0, 0, 0.5)).norm() - 0.1;
    if (std::abs(gap - kGrid.half_diagonal()) < 1e-9) continue;
    EXPECT_EQ(mask.covers(i), gap < kGrid.half_diagonal());
  }
}

TEST(ShapeMask, CoversWhatMayHaveBeenAnObject) {
  ShapeMask mask(kGrid);
  Shape shape;
  shape.geometry = Box{{0.3, 0.4, 0.05}};
  const auto part = make_convex_part(shape).value();
  // Noise of a surface fills the voxels above it, wherever the grid has its borders.
  for (const double top : {0.5001, 0.5049, 0.51, 0.5151, 0.5199}) {
    mask.set({{part, make_pose({0, 0, top - 0.025}), 0.02, Owner::kObject}});
    for (const double above : {0.0, 0.01, 0.019}) {
      const Eigen::Vector3i cell =
          ((Eigen::Vector3d(0.01, 0.01, top + above) - kGrid.low) / kGrid.edge).cast<int>();
      EXPECT_TRUE(mask.covers(kGrid.index(cell.x(), cell.y(), cell.z()))) << top << " + " << above;
    }
    const Eigen::Vector3i far =
        ((Eigen::Vector3d(0.01, 0.01, top + 0.02 + 1.01 * kGrid.edge) - kGrid.low) / kGrid.edge).cast<int>();
    EXPECT_FALSE(mask.covers(kGrid.index(far.x(), far.y(), far.z()))) << top;
  }
}

}  // namespace
}  // namespace extperfc::arm
