#include "extperfc/navigate/map_explanation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr std::int8_t kObstacle = 65;  // per cent, as map_server's threshold

}  // namespace

void MapExplanation::set_map(const OccupancyGrid& map, double margin_m) {
  near_ = map;
  std::fill(near_.cells.begin(), near_.cells.end(), OccupancyGrid::kFree);
  const auto reach = static_cast<std::size_t>(std::ceil(margin_m / map.resolution_m));
  for (std::size_t row = 0; row < map.height; ++row)
    for (std::size_t column = 0; column < map.width; ++column) {
      if (map.at(column, row) < kObstacle) continue;
      const std::size_t left = column - std::min(column, reach);
      const std::size_t right = std::min(map.width - 1, column + reach);
      for (std::size_t r = row - std::min(row, reach); r <= std::min(map.height - 1, row + reach); ++r)
        std::fill(near_.cells.begin() + static_cast<std::ptrdiff_t>(r * map.width + left),
                  near_.cells.begin() + static_cast<std::ptrdiff_t>(r * map.width + right + 1),
                  OccupancyGrid::kOccupied);
    }
}

bool MapExplanation::explains(const Eigen::Vector2d& point_m) const {
  if (near_.empty()) return false;
  const auto cell = near_.cell_of(point_m.x(), point_m.y());
  return cell && near_.at(cell->column, cell->row) == OccupancyGrid::kOccupied;
}

LaserScan MapExplanation::unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const {
  LaserScan rest = scan;
  for (std::size_t i = 0; i < rest.ranges.size(); ++i) {
    if (!is_return(scan, rest.ranges[i])) continue;
    const double range_m = rest.ranges[i];
    const double angle = map_T_sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    if (explains({map_T_sensor.x + range_m * std::cos(angle), map_T_sensor.y + range_m * std::sin(angle)}))
      rest.ranges[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return rest;
}

}  // namespace extperfc::navigate
