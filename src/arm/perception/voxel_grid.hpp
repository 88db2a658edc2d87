#pragma once

#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace extperfc::arm {

/// A block of voxels; x runs fastest.
struct VoxelGrid {
  Eigen::Vector3d low{Eigen::Vector3d::Zero()};
  double edge{0.02};
  Eigen::Vector3i count{Eigen::Vector3i::Zero()};

  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(count.x()) * static_cast<std::size_t>(count.y()) *
           static_cast<std::size_t>(count.z());
  }
  [[nodiscard]] int index(int x, int y, int z) const { return (z * count.y() + y) * count.x() + x; }
  [[nodiscard]] Eigen::Vector3i cell(int index) const {
    return {index % count.x(), index / count.x() % count.y(), index / (count.x() * count.y())};
  }
  [[nodiscard]] Eigen::Vector3d centre(const Eigen::Vector3i& cell) const {
    return low + edge * (cell.cast<double>().array() + 0.5).matrix();
  }
  /// From the middle to a corner.
  [[nodiscard]] double half_diagonal() const { return edge * std::sqrt(3.0) / 2; }
};

/// Cells from `first` to `last`, both included.
struct CellBox {
  Eigen::Vector3i first;
  Eigen::Vector3i last;
};

}  // namespace extperfc::arm
