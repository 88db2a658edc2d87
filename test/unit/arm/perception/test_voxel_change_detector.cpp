// Changes of voxels that are worth telling.
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/arm/voxel_change_detector.hpp"

namespace extperfc::arm {
namespace {

constexpr double kEdge = 0.02;
const Eigen::Vector3d kLow(0.1, -1.3, 0.3);

Eigen::Vector3d middle(int x, int y, int z) {
  return kLow + kEdge * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5));
}

std::vector<Eigen::Vector3d> wall(int x, int bulge_every = 0) {
  std::vector<Eigen::Vector3d> middles;
  for (int y = 0; y < 20; ++y)
    for (int z = 0; z < 20; ++z)
      middles.push_back(middle(x + (bulge_every > 0 && (20 * y + z) % bulge_every == 0 ? 1 : 0), y, z));
  return middles;
}

TEST(VoxelChangeDetector, TheSameIsNoChangeHoweverLong) {
  VoxelChangeDetector voxels(kLow, kEdge, 0.5);
  EXPECT_FALSE(voxels.changed({}, 0.1));
  EXPECT_TRUE(voxels.changed(wall(5), 0.2));
  EXPECT_FALSE(voxels.changed(wall(5), 100.0));
}

TEST(VoxelChangeDetector, WhatComesOrGoesIsAChangeAtOnce) {
  VoxelChangeDetector voxels(kLow, kEdge, 1e9);
  auto middles = wall(5);
  EXPECT_TRUE(voxels.changed(middles, 1e-3));
  middles.push_back(middle(8, 3, 3));
  EXPECT_TRUE(voxels.changed(middles, 2e-3));
  middles.pop_back();
  EXPECT_TRUE(voxels.changed(middles, 3e-3));
  EXPECT_TRUE(voxels.changed({}, 4e-3));
}

TEST(VoxelChangeDetector, FlickerOfSurfacesWaits) {
  VoxelChangeDetector voxels(kLow, kEdge, 0.5);
  EXPECT_TRUE(voxels.changed(wall(5), 10.0));
  EXPECT_FALSE(voxels.changed(wall(5, 3), 10.1));
  EXPECT_FALSE(voxels.changed(wall(5, 7), 10.4));
  EXPECT_TRUE(voxels.changed(wall(5, 3), 10.5));
  EXPECT_FALSE(voxels.changed(wall(5, 7), 10.9));
}

TEST(VoxelChangeDetector, SlowChangesAddUp) {
  VoxelChangeDetector voxels(kLow, kEdge, 1e9);
  EXPECT_TRUE(voxels.changed(wall(5), 1.0));
  EXPECT_FALSE(voxels.changed(wall(6), 1.1));
  EXPECT_TRUE(voxels.changed(wall(7), 1.2));
}

TEST(VoxelChangeDetector, TheBordersOfTheGridAreNoNeighbours) {
  VoxelChangeDetector voxels(kLow, kEdge, 1e9);
  EXPECT_TRUE(voxels.changed({middle(0, 4, 4)}, 1.0));
  EXPECT_TRUE(voxels.changed({middle(79, 3, 4)}, 1.1));
  EXPECT_TRUE(voxels.changed({middle(79, 0, 4)}, 1.2));
}

TEST(VoxelChangeDetector, AClockThatWentBackDoesNotHoldChangesBack) {
  VoxelChangeDetector voxels(kLow, kEdge, 0.5);
  EXPECT_TRUE(voxels.changed(wall(5), 1000.0));
  EXPECT_TRUE(voxels.changed(wall(6), 1.0));
}

}  // namespace
}  // namespace extperfc::arm
