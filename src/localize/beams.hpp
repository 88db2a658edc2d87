#pragma once

#include <vector>

#include "extperfc/localize/localizer.hpp"

namespace extperfc::localize {

/// The rays of a scan that a sensor model weighs.
struct Beams {
  std::vector<float> x_m;  ///< end points of the rays that met something, in the base's frame
  std::vector<float> y_m;
  std::vector<float> range_m;    ///< of every ray, as many or more
  std::vector<float> angle_rad;  ///< of every ray, in the base's frame
  float sensor_x_m{0};           ///< where the rays begin, in the base's frame
  float sensor_y_m{0};
  double max_range_m{0};  ///< readings of this and more are no return

  [[nodiscard]] std::size_t ends() const { return x_m.size(); }
};

/// At most `laser_max_beams` rays, evenly spaced over the usable ones: NaN, zero, negative ranges and those
/// below the shortest range are not. Infinite ranges and those above the longest are no return: the
/// likelihood field has no use for them, the beam model takes them as readings of the longest range.
[[nodiscard]] Beams select_beams(const LaserScan& scan, const LocalizerParams& params);

}  // namespace extperfc::localize
