#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::scan {

/// Which direction belongs to which ray. A ray stands in the middle of its bin.
class RayLayout {
 public:
  explicit RayLayout(const ScanParams& params);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool full_revolution() const { return full_revolution_; }

  /// Of the direction (x, y); count() when there is no ray. NaN has no direction of its own: any ray, or
  /// none.
  [[nodiscard]] std::size_t ray_of(float x, float y) const;
  /// Of many directions; `y` is as long as `x`.
  void rays_of(const std::vector<float>& x, const std::vector<float>& y,
               std::vector<std::uint32_t>& rays) const;

  /// The neighbour of `ray`, `step` = -1 or 1; `ray` itself where there is none.
  [[nodiscard]] std::size_t neighbour(std::size_t ray, int step) const;

  /// A scan of the layout's size without any range.
  void clear(PlanarScan& scan, bool with_intensity) const;

 private:
  /// Without branches and calls, so that a loop over arrays takes several directions at a time.
  struct Bins {
    float first_edge_rad;  ///< lower edge of the first ray's bin, in [-pi, pi]
    float per_rad;
    float none;                                                         ///< the number of rays
    [[nodiscard]] inline std::uint32_t bin_of(float x, float y) const;  ///< `none` for NaN, too
  };

  double angle_min_;
  double angle_increment_;
  std::size_t count_;
  bool full_revolution_;
  Bins bins_;
};

}  // namespace extperfc::scan
