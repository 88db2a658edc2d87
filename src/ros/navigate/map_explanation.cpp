#include "ros/navigate/map_explanation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::ros_navigate {

namespace {

constexpr std::int8_t kLethalPercent = 65;

}  // namespace

void MapExplanation::set_map(const OccupancyGrid& map, double margin_m) {
  near_ = map;
  std::fill(near_.cells.begin(), near_.cells.end(), OccupancyGrid::kFree);
  const auto reach = static_cast<std::size_t>(std::ceil(margin_m / map.resolution_m));
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      if (map.at(column, row) < kLethalPercent) continue;
      const std::size_t left = column - std::min(column, reach);
      const std::size_t right = std::min(map.width - 1, column + reach);
      for (std::size_t r = row - std::min(row, reach); r <= std::min(map.height - 1, row + reach); ++r)
        std::fill(near_.cells.begin() + static_cast<std::ptrdiff_t>(r * map.width + left),
                  near_.cells.begin() + static_cast<std::ptrdiff_t>(r * map.width + right + 1),
                  OccupancyGrid::kOccupied);
    }
}

LaserScan MapExplanation::unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const {
  LaserScan rest = scan;
  if (near_.empty()) return rest;
  for (std::size_t i = 0; i < rest.ranges.size(); ++i) {
    const double range = rest.ranges[i];
    if (!(range >= scan.range_min && range <= scan.range_max)) continue;
    const double angle = map_T_sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const auto cell =
        near_.cell_of(map_T_sensor.x + range * std::cos(angle), map_T_sensor.y + range * std::sin(angle));
    if (cell && near_.at(cell->column, cell->row) == OccupancyGrid::kOccupied)
      rest.ranges[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return rest;
}

}  // namespace extperfc::ros_navigate
