#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

namespace extperfc::arm {

/// Distinguishes changes of a set of voxels from the flicker of its surfaces, to avoid costly work after
/// every image. Not thread-safe; deterministic.
class VoxelChangeDetector {
 public:
  /// A corner of the grid [m], the edge of its voxels [m], above 0, and after how long small changes count
  /// [s].
  VoxelChangeDetector(const Eigen::Vector3d& low_m, double voxel_m, double patience_s)
      : low_m_(low_m), voxel_m_(voxel_m), patience_s_(patience_s) {}

  /// True when the voxels with these centres differ from those reported last (initially none): at once where
  /// an added or removed voxel has no voxel of the other set among its 26 neighbours, or where one set is
  /// empty; for smaller differences after `patience_s`. O(voxels).
  [[nodiscard]] bool changed(const std::vector<Eigen::Vector3d>& middles, double time_s);

 private:
  using Keys = std::unordered_set<std::int64_t>;

  const Eigen::Vector3d low_m_;
  const double voxel_m_;
  const double patience_s_;
  Keys reported_;
  double reported_s_{0};
};

}  // namespace extperfc::arm
