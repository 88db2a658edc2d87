#pragma once

#include <algorithm>

namespace extperfc::depth {

/// Standard deviation [px] of the centre of a detector's box along a side of `side_px`: about 3 % of the
/// side, and a pixel at least.
[[nodiscard]] inline double center_sigma_px(double side_px) {
  constexpr double kPart = 0.03;
  return std::max(1.0, kPart * side_px);
}

}  // namespace extperfc::depth
