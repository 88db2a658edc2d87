#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/scan_points.hpp"

namespace extperfc::mapping {

/// A scan that the map is made of, or was: of places seen often the pose alone stays. Its pose in the map is
/// the pose graph's.
struct KeyFrame {
  std::size_t scan{0};    ///< number of the scan it was made from
  double travelled_m{0};  ///< distance travelled up to here
  ScanPoints points;      ///< empty once the place has been seen often enough

  [[nodiscard]] bool is_thinned() const { return points.surface.empty(); }
};

}  // namespace extperfc::mapping
