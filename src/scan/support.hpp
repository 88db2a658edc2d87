#pragma once

#include <optional>
#include <vector>

#include "scan/columns.hpp"

namespace extperfc::scan {

/// A surface of one column.
struct Surface {
  float range{0};          ///< mean of its points [m]
  std::uint32_t index{0};  ///< of its nearest point
  bool two_rings{false};   ///< at least two rings agree on it
};

/// The nearest surface of `middle` that is no speckle: see PlanarScans::supported. `left` and `right` are the
/// neighbouring columns (or `middle` again at the end of a sector); `level` separates rings, by the points'
/// index; points within `support_m` belong together.
[[nodiscard]] std::optional<Surface> supported_surface(const Column& middle, const Column& left,
                                                       const Column& right, const std::vector<float>& level,
                                                       float support_m);

/// The range at which the nearest surface of a column stands [m]: of n points of one surface the nearest lies
/// before it by what the smallest of n normal numbers of deviation `noise_m` lies below their mean. n: points
/// up to four deviations behind the nearest. A lone point keeps its range. The column must not be empty.
[[nodiscard]] float nearest_range(const Column& column, float noise_m);

}  // namespace extperfc::scan
