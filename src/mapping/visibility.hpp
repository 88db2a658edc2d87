#pragma once

#include <array>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

#include "mapping/scan_points.hpp"
#include "mapping/surface_map.hpp"

namespace extperfc::mapping {

/// Known free range in each direction about the scanner of one scan, in the base's frame. Directions without
/// a return are unknown.
class RangeProfile {
 public:
  explicit RangeProfile(const ScanPoints& points);

  /// True when a surface at `point` (base's frame) would have stopped the scan's rays long before they ended.
  [[nodiscard]] bool sees_through(const Eigen::Vector2f& point) const;

 private:
  static constexpr std::size_t kBins = 360;

  Eigen::Vector2f scanner_;
  std::array<float, kBins> free_to_m_{};  ///< 0: unknown
  float farthest_free_m_{0};
};

/// Fraction of the scan's points that stand where `other`, seen from `other_T_base`, saw free space, [0, 1].
[[nodiscard]] double fraction_in_free_space(const RangeProfile& other, const ScanPoints& points,
                                            const Pose2& other_T_base);

/// Fraction of the map's surfaces within `radius_m` of the base that the scan, taken from `map_T_base`,
/// saw through, [0, 1].
[[nodiscard]] double fraction_seen_through(const RangeProfile& scan, const SurfaceMap& map,
                                           const Pose2& map_T_base, double radius_m);

}  // namespace extperfc::mapping
