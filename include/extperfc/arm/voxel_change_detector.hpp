#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include <Eigen/Core>

namespace extperfc::arm {

/// Tells changes of a set of voxels from the flicker of its surfaces, so that costly work is not done anew
/// for every picture. Not thread-safe; deterministic.
class VoxelChangeDetector {
 public:
  /// A corner of the grid [m], the edge of its voxels [m], above 0, and after how long small changes count
  /// [s].
  VoxelChangeDetector(const Eigen::Vector3d& low_m, double voxel_m, double patience_s)
      : low_m_(low_m), voxel_m_(voxel_m), patience_s_(patience_s) {}

  /// Whether the voxels with these middles are news compared with those that were news last (none at first):
  /// at once where a voxel that came or went has none of the other set among its 26 neighbours, or one set is
  /// empty; with smaller differences when `patience_s` has passed. O(voxels).
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
