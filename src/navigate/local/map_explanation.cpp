#include "extperfc/navigate/map_explanation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr std::int8_t kObstacle = 65;  // per cent, as map_server's threshold
constexpr std::int8_t kFar = 120;      // cells
constexpr double kBetweenMapsS = 0.5;
constexpr double kMarginPerMetre_m = 0.035;  // of range: a localizer's heading is up to two degrees wrong

std::int8_t one_more(std::int8_t cells) {
  return cells < kFar ? static_cast<std::int8_t>(cells + 1) : kFar;
}

}  // namespace

void MapExplanation::set_map(const OccupancyGrid& map, double margin_m) {
  margin_m_ = margin_m;
  away_ = map;
  for (auto& cell : away_.cells) cell = cell >= kObstacle ? std::int8_t{0} : kFar;
  const auto width = static_cast<std::ptrdiff_t>(map.width);
  const auto height = static_cast<std::ptrdiff_t>(map.height);
  const auto at = [&](std::ptrdiff_t column, std::ptrdiff_t row) -> std::int8_t& {
    return away_.cells[static_cast<std::size_t>(row * width + column)];
  };
  // Least over the neighbours that were visited before: the row before, and the cell before.
  const auto visit = [&](std::ptrdiff_t column, std::ptrdiff_t row, std::ptrdiff_t back) {
    std::int8_t& cell = at(column, row);
    if (column + back >= 0 && column + back < width) cell = std::min(cell, one_more(at(column + back, row)));
    if (row + back < 0 || row + back >= height) return;
    for (std::ptrdiff_t c = std::max<std::ptrdiff_t>(0, column - 1); c <= std::min(width - 1, column + 1);
         ++c)
      cell = std::min(cell, one_more(at(c, row + back)));
  };
  for (std::ptrdiff_t row = 0; row < height; ++row)
    for (std::ptrdiff_t column = 0; column < width; ++column) visit(column, row, -1);
  for (std::ptrdiff_t row = height - 1; row >= 0; --row)
    for (std::ptrdiff_t column = width - 1; column >= 0; --column) visit(column, row, 1);
}

bool MapExplanation::explains(const Eigen::Vector2d& point_m, double range_m) const {
  if (away_.empty()) return false;
  const auto cell = away_.cell_of(point_m.x(), point_m.y());
  if (!cell) return false;
  const double margin_cells = std::ceil((margin_m_ + kMarginPerMetre_m * range_m) / away_.resolution_m);
  return away_.at(cell->column, cell->row) <= std::min(margin_cells, kFar - 1.0);
}

LaserScan MapExplanation::unexplained(const LaserScan& scan, const Pose2& map_T_sensor) const {
  LaserScan rest = scan;
  for (std::size_t i = 0; i < rest.ranges.size(); ++i) {
    if (!is_return(scan, rest.ranges[i])) continue;
    const double range_m = rest.ranges[i];
    const double angle = map_T_sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    if (explains({map_T_sensor.x + range_m * std::cos(angle), map_T_sensor.y + range_m * std::sin(angle)},
                 range_m))
      rest.ranges[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return rest;
}

void MapHistory::add(const OccupancyGrid& map, double margin_m, double stamp_s) {
  if (!maps_.empty() && stamp_s < maps_.back().stamp_s) maps_.clear();
  // Few are kept: of maps that come fast, the newest takes the place of the one before.
  if (maps_.size() > 1 && maps_.back().stamp_s - maps_[maps_.size() - 2].stamp_s < kBetweenMapsS)
    maps_.pop_back();
  maps_.emplace_back();
  maps_.back().stamp_s = stamp_s;
  maps_.back().map.set_map(map, margin_m);
  while (maps_.size() > 1 && maps_[1].stamp_s <= stamp_s - old_s_) maps_.pop_front();
}

const MapExplanation& MapHistory::newest() const {
  static const MapExplanation kNone;
  return maps_.empty() ? kNone : maps_.back().map;
}

const MapExplanation& MapHistory::old() const {
  return maps_.empty() ? newest() : maps_.front().map;
}

std::optional<double> MapHistory::old_stamp_s() const {
  return maps_.empty() ? std::nullopt : std::optional(maps_.front().stamp_s);
}

}  // namespace extperfc::navigate
