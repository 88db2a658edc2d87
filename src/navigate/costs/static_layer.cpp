#include "extperfc/navigate/static_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "extperfc/base/demand.hpp"

#include "navigate/costs/map_costs.hpp"
#include "navigate/costs/row_spans.hpp"

namespace extperfc::navigate {

namespace {

constexpr std::size_t kMaxCells = 1U << 28U;  // [cells]

CostOfValue costs_of_values(const StaticParams& params) {
  constexpr int kMaxScaled = kInscribedCost - 1;
  CostOfValue costs{};
  for (int bits = 0; bits < 256; ++bits) {
    const int percent = bits < 128 ? bits : bits - 256;
    Cost& cost = costs[static_cast<std::size_t>(bits)];
    if (percent < 0)
      cost = params.unknown_is_free ? kFreeCost : kUnknownCost;
    else if (percent >= params.lethal_percent)
      cost = kLethalCost;
    else
      cost = params.trinary ? kFreeCost : static_cast<Cost>(kMaxScaled * percent / params.lethal_percent);
  }
  return costs;
}

std::string problem_of(const OccupancyGrid& map) {
  if (map.width == 0 || map.height == 0) return "the map has no cells";
  if (map.width > kMaxCells || map.height > kMaxCells || map.cells.size() != map.width * map.height)
    return "the map must have width times height cells";
  if (!is_finite(map.origin) || !std::isfinite(map.resolution_m) || map.resolution_m <= 0)
    return "the map's origin must be finite and its resolution above 0";
  return "";
}

}  // namespace

CostGrid grid_around(const OccupancyGrid& map, Cost cost) {
  demand(problem_of(map).empty(), problem_of(map));
  const double r = map.resolution_m;
  const Eigen::Vector2d high(r * static_cast<double>(map.width), r * static_cast<double>(map.height));
  CostGrid unit;
  unit.resolution_m = r;
  const Bounds bounds({{0, 0}, {high.x(), 0}, high, {0, high.y()}}, ToCells(unit, map.origin));
  const double width = std::ceil(bounds.columns.high - bounds.columns.low - kMinOverlap);
  const double height = std::ceil(bounds.rows.high - bounds.rows.low - kMinOverlap);
  constexpr double kTooMany = 1e6;
  return make_cost_grid(static_cast<int>(std::min(width, kTooMany)),
                        static_cast<int>(std::min(height, kTooMany)), r,
                        r * Eigen::Vector2d(bounds.columns.low, bounds.rows.low), cost);
}

CostGrid costs_of(const OccupancyGrid& map, const StaticParams& params) {
  CostGrid grid = grid_around(map, kUnknownCost);
  draw_map(map, {}, costs_of_values(params), grid, grid.box());
  return grid;
}

StaticLayer::StaticLayer(const StaticParams& params) : params_(params) {
  demand(params.lethal_percent >= 1 && params.lethal_percent <= 100, "lethal_percent must be 1 to 100");
}

Result<void> StaticLayer::set_map(OccupancyGrid map, const Pose2& grid_T_map) {
  if (const auto problem = problem_of(map); !problem.empty())
    return fail(ErrorCode::kInvalidArgument, problem);
  if (!is_finite(grid_T_map)) return fail(ErrorCode::kInvalidArgument, "the pose of the map must be finite");
  map_ = std::move(map);
  grid_T_map_ = grid_T_map;
  draw(costs_.box());
  return {};
}

Result<void> StaticLayer::update_map(const CellBox& map_box, const std::vector<std::int8_t>& cells) {
  const CellBox all{{0, 0}, {static_cast<int>(map_.width), static_cast<int>(map_.height)}};
  const auto refuse = [](const std::string& why) { return fail(ErrorCode::kInvalidArgument, why); };
  if (map_.empty()) return refuse("a map must come before its updates");
  if (map_box.empty() || map_box.min.column < 0 || map_box.min.row < 0 ||
      map_box.max.column > all.max.column || map_box.max.row > all.max.row)
    return refuse("the update of a map must be inside the map");
  const auto width = static_cast<std::size_t>(map_box.max.column - map_box.min.column);
  const auto height = static_cast<std::size_t>(map_box.max.row - map_box.min.row);
  if (cells.size() != width * height)
    return refuse("the update of a map must have " + std::to_string(width * height) + " cells, not " +
                  std::to_string(cells.size()));
  for (std::size_t row = 0; row < height; ++row)
    std::copy_n(&cells[row * width], width,
                &map_.cells[(static_cast<std::size_t>(map_box.min.row) + row) * map_.width +
                            static_cast<std::size_t>(map_box.min.column)]);
  draw(cells_under(map_, map_box, grid_T_map_, costs_).clipped(costs_.box()));
  return {};
}

void StaticLayer::draw(const CellBox& box) {
  if (box.empty()) return;
  for (int row = box.min.row; row < box.max.row; ++row)
    std::fill_n(&costs_.at({box.min.column, row}), box.max.column - box.min.column, kOutsideMap);
  draw_map(map_, grid_T_map_, costs_of_values(params_), costs_, box);
  changed_ = changed_.joined(box);
}

void StaticLayer::match(const CostGrid& grid) {
  costs_ = grid;
  changed_ = {};
  draw(costs_.box());
}

CellBox StaticLayer::take_changes(const CostGrid& /*grid*/, double /*now_s*/) {
  return std::exchange(changed_, CellBox{});
}

void StaticLayer::write(CostGrid& grid, const CellBox& box) {
  for (int row = box.min.row; row < box.max.row; ++row)
    for (int column = box.min.column; column < box.max.column; ++column)
      if (const Cost cost = costs_.at({column, row}); cost != kOutsideMap) grid.at({column, row}) = cost;
}

}  // namespace extperfc::navigate
