#include "extperfc/navigate/zone_layer.hpp"

#include <algorithm>
#include <utility>

#include "extperfc/base/demand.hpp"

#include "navigate/costs/map_costs.hpp"
#include "navigate/costs/polygon.hpp"
#include "navigate/costs/row_spans.hpp"
#include "navigate/costs/zone_limits.hpp"

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;

/// Throws for a polygon that is not simple.
void normalize(Zone& zone) {
  auto polygon = make_polygon(std::move(zone.corners_m), kMaxZoneCorners);
  demand(polygon.has_value(), "zone " + zone.name + ": " + (polygon ? "" : polygon.error().message));
  zone.corners_m = std::move(*polygon);
}

CostOfValue occupied_is_lethal() {
  constexpr std::size_t kMinPercent = 65;
  constexpr std::size_t kMaxValue = 127;
  CostOfValue costs{};
  std::fill(costs.begin() + kMinPercent, costs.begin() + kMaxValue + 1, kLethalCost);
  return costs;
}

}  // namespace

void ZoneLayer::set_zones(Zones zones) {
  std::vector<Polygon> parts_m;
  for (Zone& zone : zones.keep_out) {
    normalize(zone);
    for (auto& part_m : convex_parts(zone.corners_m)) parts_m.push_back(std::move(part_m));
  }
  for (SpeedZone& zone : zones.speed) {
    normalize(zone);
    demand(zone.factor > 0 && zone.factor <= 1,
           "zone " + zone.name + ": its factor must be above 0, at most 1");
  }
  zones_ = std::move(zones);
  parts_m_ = std::move(parts_m);
  draw();
}

void ZoneLayer::set_pose(const Pose2& grid_T_map) {
  const bool same =
      grid_T_map.x == grid_T_map_.x && grid_T_map.y == grid_T_map_.y && grid_T_map.yaw == grid_T_map_.yaw;
  grid_T_map_ = grid_T_map;
  if (has_keep_out() && !same) draw();
}

bool ZoneLayer::has_keep_out() const {
  return !parts_m_.empty() || !zones_.keep_out_maps.empty();
}

double ZoneLayer::speed_factor_at(const Vector2d& point_m) const {
  if (zones_.speed.empty()) return 1;
  const Pose2 in_map = compose(inverse(grid_T_map_), {point_m.x(), point_m.y(), 0});
  double factor = 1;
  for (const SpeedZone& zone : zones_.speed)
    if (contains(zone.corners_m, {in_map.x, in_map.y})) factor = std::min(factor, zone.factor);
  return factor;
}

void ZoneLayer::draw() {
  changed_ = true;
  std::fill(costs_.cells.begin(), costs_.cells.end(), kFreeCost);
  const CostOfValue costs = occupied_is_lethal();
  for (const OccupancyGrid& map : zones_.keep_out_maps) {
    CostGrid drawn = costs_;
    std::fill(drawn.cells.begin(), drawn.cells.end(), kOutsideMap);
    draw_map(map, grid_T_map_, costs, drawn, drawn.box());
    std::transform(costs_.cells.begin(), costs_.cells.end(), drawn.cells.begin(), costs_.cells.begin(),
                   worse_of);
  }
  const ToCells to_cells(costs_, grid_T_map_);
  for (const Polygon& part_m : parts_m_)
    visit_rows(costs_, part_m, to_cells, Bounds(part_m, to_cells), [&](int row, int begin, int end) {
      std::fill_n(&costs_.at({begin, row}), end - begin, kLethalCost);
      return true;
    });
}

void ZoneLayer::match(const CostGrid& grid) {
  costs_ = grid;
  draw();
}

CellBox ZoneLayer::take_changes(const CostGrid& grid, double /*now_s*/) {
  return std::exchange(changed_, false) ? grid.box() : CellBox{};
}

void ZoneLayer::write(CostGrid& grid, const CellBox& box) {
  if (!has_keep_out()) return;
  for (int row = box.min.row; row < box.max.row; ++row)
    for (int column = box.min.column; column < box.max.column; ++column)
      if (costs_.at({column, row}) == kLethalCost) grid.at({column, row}) = kLethalCost;
}

}  // namespace extperfc::navigate
