// Solids of revolution for look-alikes.

#include <algorithm>

#include <gtest/gtest.h>

#include "simulate/worlds/lathe.hpp"

namespace extperfc::simulate {
namespace {

/// Volume by the divergence theorem; positive when every face looks outwards.
double volume_of(const TriangleMesh& mesh) {
  double sum = 0;
  for (const Triangle& t : *mesh.triangles) {
    const auto corner = [&](std::size_t i) {
      return Eigen::Vector3d(t.at(i).cast<double>().cwiseProduct(mesh.scale));
    };
    sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  return sum;
}

TEST(Lathe, FillsTheBoxAroundItsMiddle) {
  const auto mesh = lathe("vase", vase_profile(0.4), 28, {0.1, 0.2, 0.3});
  Eigen::Array3f low = Eigen::Array3f::Constant(9);
  Eigen::Array3f high = -low;
  for (const Triangle& triangle : *mesh.triangles)
    for (const auto& corner : triangle) {
      low = low.min(corner.array());
      high = high.max(corner.array());
    }
  EXPECT_TRUE(low.isApproxToConstant(-0.5F, 1e-5F)) << low.transpose();
  EXPECT_TRUE(high.isApproxToConstant(0.5F, 1e-5F)) << high.transpose();
  EXPECT_EQ(mesh.scale, Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST(Lathe, VolumesAreThoseOfTheSolids) {
  // The pyramid's square stands with its sides along x and y.
  EXPECT_NEAR(volume_of(lathe("pyramid", frustum_profile(0), 4, {1, 1, 1})), 1.0 / 3, 1e-5);
  EXPECT_NEAR(volume_of(lathe("block", frustum_profile(1), 4, {1, 2, 3})), 6, 1e-5);
  EXPECT_NEAR(volume_of(lathe("frustum", frustum_profile(0.5), 4, {1, 1, 1})), 7.0 / 12, 1e-5);
  EXPECT_NEAR(volume_of(lathe("ball", ellipse_profile(), 60, {1, 1, 1})), 0.5236, 0.012);
  EXPECT_NEAR(volume_of(lathe("dome", dome_profile(), 60, {1, 1, 0.5})), 0.2618, 0.006);
}

}  // namespace
}  // namespace extperfc::simulate
