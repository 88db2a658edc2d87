#include "extperfc/navigate/cost_grid.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/demand.hpp"

namespace extperfc::navigate {

namespace {

constexpr int kMaxSide = 30000;

}  // namespace

Cost Inflation::cost_at(double distance_m) const {
  if (distance_m <= 0) return kLethalCost;
  constexpr double kRounding = 1e-9;  // [m]: 11 cells of 0.05 m are within 0.55 m
  if (distance_m > radius_m + kRounding) return kFreeCost;
  if (distance_m <= inscribed_radius_m + kRounding) return kInscribedCost;
  constexpr double kMaxCost = kInscribedCost - 1;
  return static_cast<Cost>(kMaxCost * std::exp(-cost_scaling_factor * (distance_m - inscribed_radius_m)));
}

CellBox CellBox::joined(const CellBox& other) const {
  if (other.empty()) return *this;
  if (empty()) return other;
  return {{std::min(min.column, other.min.column), std::min(min.row, other.min.row)},
          {std::max(max.column, other.max.column), std::max(max.row, other.max.row)}};
}

CellBox CellBox::clipped(const CellBox& other) const {
  return {{std::max(min.column, other.min.column), std::max(min.row, other.min.row)},
          {std::min(max.column, other.max.column), std::min(max.row, other.max.row)}};
}

CellBox CellBox::grown(int cells) const {
  if (empty()) return *this;
  return {{min.column - cells, min.row - cells}, {max.column + cells, max.row + cells}};
}

Cell CostGrid::cell_around(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d in_cells = (point_m - origin_m) / resolution_m;
  return {static_cast<int>(std::floor(in_cells.x())), static_cast<int>(std::floor(in_cells.y()))};
}

std::optional<Cell> CostGrid::cell_of(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d in_cells = (point_m - origin_m) / resolution_m;
  // Written so that NaN is outside.
  if (!(in_cells.x() >= 0 && in_cells.y() >= 0 && in_cells.x() < width && in_cells.y() < height))
    return std::nullopt;
  return Cell{static_cast<int>(in_cells.x()), static_cast<int>(in_cells.y())};
}

CostGrid make_cost_grid(int width, int height, double resolution_m, const Eigen::Vector2d& origin_m,
                        Cost cost) {
  demand(width > 0 && height > 0 && width <= kMaxSide && height <= kMaxSide,
         "a cost grid must have 1 to 30000 cells along each side");
  demand(std::isfinite(resolution_m) && resolution_m > 0, "resolution of a cost grid must be above 0");
  demand(origin_m.allFinite(), "origin of a cost grid must be finite");
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return {width, height, resolution_m, origin_m, std::vector<Cost>(count, cost), {}, cost == kUnknownCost};
}

}  // namespace extperfc::navigate
