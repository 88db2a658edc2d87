#include "localize/beams.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::localize {

namespace {

/// Numbers of the rays that count.
std::vector<std::size_t> useful_rays(const LaserScan& scan, double shortest, double longest,
                                     bool with_misses) {
  std::vector<std::size_t> rays;
  rays.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = scan.ranges[i];
    const bool usable = range > 0 && range >= shortest;  // false for NaN
    if (usable && (with_misses || range < longest)) rays.push_back(i);
  }
  return rays;
}

}  // namespace

Beams select_beams(const LaserScan& scan, const LocalizerParams& params) {
  const double shortest = params.laser_min_range >= 0 ? params.laser_min_range : scan.range_min;
  const double longest =
      params.laser_max_range > 0 ? std::min(params.laser_max_range, scan.range_max) : scan.range_max;
  const auto rays = useful_rays(scan, shortest, longest, params.sensor_model == SensorModel::kBeam);
  const std::size_t count = std::min(rays.size(), static_cast<std::size_t>(params.laser_max_beams));
  Beams beams;
  beams.max_range_m = longest;
  beams.sensor_x_m = static_cast<float>(scan.base_T_sensor.x);
  beams.sensor_y_m = static_cast<float>(scan.base_T_sensor.y);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t ray = count < 2 ? rays[0] : rays[i * (rays.size() - 1) / (count - 1)];
    const double range = scan.ranges[ray];
    const double angle =
        scan.base_T_sensor.yaw + scan.angle_min + static_cast<double>(ray) * scan.angle_increment;
    beams.range_m.push_back(static_cast<float>(std::min(range, longest)));
    beams.angle_rad.push_back(static_cast<float>(angle));
    if (range >= longest) continue;
    beams.x_m.push_back(static_cast<float>(scan.base_T_sensor.x + range * std::cos(angle)));
    beams.y_m.push_back(static_cast<float>(scan.base_T_sensor.y + range * std::sin(angle)));
  }
  return beams;
}

}  // namespace extperfc::localize
