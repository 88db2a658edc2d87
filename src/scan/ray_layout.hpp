#pragma once

#include <cstddef>

#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::scan {

/// Which direction belongs to which ray. A ray stands in the middle of its bin.
class RayLayout {
 public:
  explicit RayLayout(const ScanParams& params);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool full_turn() const { return full_turn_; }

  /// Of the direction (x, y); count() or more when there is no ray.
  [[nodiscard]] std::size_t ray_of(float x, float y) const;

  /// The ray beside `ray`, `step` = -1 or 1; `ray` itself where there is none.
  [[nodiscard]] std::size_t beside(std::size_t ray, int step) const;

  /// A scan of the layout's size without any range.
  void clear(PlanarScan& scan, bool with_intensity) const;

 private:
  double angle_min_;
  double angle_increment_;
  std::size_t count_;
  bool full_turn_;
  float rays_per_rad_;
  float first_edge_rad_;  ///< lower edge of the first ray's bin
};

}  // namespace extperfc::scan
