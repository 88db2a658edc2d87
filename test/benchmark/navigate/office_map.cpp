#include "test/benchmark/navigate/office_map.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "extperfc/base/rng.hpp"

namespace extperfc::benchmark {

namespace {

using navigate::Cell;
using navigate::CellBox;
using navigate::Cost;
using navigate::CostGrid;

constexpr double kCell_m = 0.05;

int cells(double metres) {
  return static_cast<int>(std::lround(metres / kCell_m));
}

void fill(CostGrid& grid, const CellBox& box, Cost cost) {
  const CellBox inside = box.clipped(grid.box());
  for (int row = inside.min.row; row < inside.max.row; ++row)
    for (int column = inside.min.column; column < inside.max.column; ++column) grid.at({column, row}) = cost;
}

/// The outline of a box, `thick` cells inwards.
void draw_walls(CostGrid& grid, const CellBox& box, int thick) {
  fill(grid, {box.min, {box.max.column, box.min.row + thick}}, navigate::kLethalCost);
  fill(grid, {{box.min.column, box.max.row - thick}, box.max}, navigate::kLethalCost);
  fill(grid, {box.min, {box.min.column + thick, box.max.row}}, navigate::kLethalCost);
  fill(grid, {{box.max.column - thick, box.min.row}, box.max}, navigate::kLethalCost);
}

class Office {
 public:
  Office(const OfficeParams& params, std::uint64_t seed)
      : params_(params),
        rng_(seed),
        grid_(navigate::make_cost_grid(params.width, params.height, params.resolution_m,
                                       Eigen::Vector2d(-3.0, 2.0), navigate::kFreeCost)) {}

  CostGrid make() {
    draw_walls(grid_, grid_.box(), kWall);
    const auto columns = wings(params_.width);
    const auto rows = wings(params_.height);
    for (const auto& [bottom, top] : rows)
      for (const auto& [left, right] : columns) add_wing({{left, bottom}, {right, top}});
    for (const auto& [at, room] : doors_) open_door(at, room);
    return std::move(grid_);
  }

 private:
  static constexpr int kWall = 3;

  struct Span {
    int low;
    int high;
  };
  struct Door {
    Cell at;
    bool in_a_row;  ///< of a wall along a row
  };

  /// Wings between corridors of 1.6 to 3 m, along one axis.
  std::vector<Span> wings(int length) {
    std::vector<Span> spans;
    int at = kWall + cells(rng_.uniform(1.6, 3.0));
    while (at + cells(8) < length) {
      const int high = std::min(at + cells(rng_.uniform(9, 22)), length - kWall - cells(1.6));
      if (high - at > cells(4)) spans.push_back({at, high});
      at = high + cells(rng_.uniform(1.6, 3.0));
    }
    return spans;
  }

  void add_wing(const CellBox& box) {
    draw_walls(grid_, box, kWall);
    if (rng_.chance(params_.open_fraction)) {
      for (int k = 0; k < 4; ++k) add_outer_door(box, k);
      add_clutter(box, 2 * params_.clutter);
      return;
    }
    split(box, box);
  }

  /// Binary splits until both sides are below 4 to 9 m; a wall that splits gets a door now and then.
  void split(const CellBox& box, const CellBox& wing) {
    const int width = box.max.column - box.min.column;
    const int height = box.max.row - box.min.row;
    const int limit = cells(rng_.uniform(4, 9));
    if (std::max(width, height) <= limit || std::max(width, height) < cells(5.5)) return finish(box, wing);
    const bool across = width > height;
    const int length = across ? width : height;
    const int at = rng_.integer(cells(2.6), length - cells(2.6));
    CellBox low = box;
    CellBox high = box;
    (across ? low.max.column : low.max.row) = (across ? box.min.column : box.min.row) + at + kWall;
    (across ? high.min.column : high.min.row) = (across ? box.min.column : box.min.row) + at;
    split(low, wing);
    split(high, wing);
    draw_walls(grid_, low, kWall);
    draw_walls(grid_, high, kWall);
    const bool inner = touches_no_corridor(low, wing) || touches_no_corridor(high, wing);
    if (!inner && !rng_.chance(0.3)) return;
    const Cell middle = across ? Cell{high.min.column + 1, middle_of(box.min.row, box.max.row)}
                               : Cell{middle_of(box.min.column, box.max.column), high.min.row + 1};
    doors_.push_back({middle, !across});
  }

  static bool touches_no_corridor(const CellBox& box, const CellBox& wing) {
    return box.min.column > wing.min.column && box.min.row > wing.min.row &&
           box.max.column < wing.max.column && box.max.row < wing.max.row;
  }

  int middle_of(int low, int high) { return rng_.integer(low + cells(1.0), high - cells(1.0)); }

  void finish(const CellBox& box, const CellBox& wing) {
    add_clutter(box, params_.clutter);
    std::vector<int> sides;
    if (box.min.row == wing.min.row) sides.push_back(0);
    if (box.max.row == wing.max.row) sides.push_back(1);
    if (box.min.column == wing.min.column) sides.push_back(2);
    if (box.max.column == wing.max.column) sides.push_back(3);
    if (sides.empty()) return;
    add_outer_door(box, sides[static_cast<std::size_t>(rng_.integer(0, static_cast<int>(sides.size()) - 1))]);
  }

  void add_outer_door(const CellBox& box, int side) {
    const int column = middle_of(box.min.column, box.max.column);
    const int row = middle_of(box.min.row, box.max.row);
    if (side == 0) doors_.push_back({{column, box.min.row + 1}, true});
    if (side == 1) doors_.push_back({{column, box.max.row - 2}, true});
    if (side == 2) doors_.push_back({{box.min.column + 1, row}, false});
    if (side == 3) doors_.push_back({{box.max.column - 2, row}, false});
  }

  /// A free rectangle through the wall, and 1.3 m without clutter on both sides.
  void open_door(const Cell& at, bool in_a_row) {
    const int half = cells(rng_.uniform(0.8, 1.2)) / 2;
    const int deep = kWall;
    const CellBox gap =
        in_a_row ? CellBox{{at.column - half, at.row - deep}, {at.column + half, at.row + deep + 1}}
                 : CellBox{{at.column - deep, at.row - half}, {at.column + deep + 1, at.row + half}};
    fill(grid_, gap, navigate::kFreeCost);
  }

  void add_clutter(const CellBox& box, double fraction) {
    const int keep = cells(1.3);
    const CellBox inside = box.grown(-keep);
    if (inside.empty()) return;
    double left = fraction * (box.max.column - box.min.column) * (box.max.row - box.min.row);
    for (int k = 0; k < 40 && left > 0; ++k) {
      const int width = cells(rng_.uniform(0.2, 1.6));
      const int height = cells(rng_.uniform(0.2, 0.9));
      const Cell at{rng_.integer(inside.min.column, inside.max.column - 1),
                    rng_.integer(inside.min.row, inside.max.row - 1)};
      fill(grid_, CellBox{at, {at.column + width, at.row + height}}.clipped(inside), navigate::kLethalCost);
      left -= width * height;
    }
  }

  OfficeParams params_;
  Rng rng_;
  CostGrid grid_;
  std::vector<Door> doors_;
};

/// Squared distances [cells] to the nearest lethal cell: two passes of lower envelopes (Felzenszwalb and
/// Huttenlocher 2012).
std::vector<float> squared_distances(const CostGrid& grid) {
  constexpr float kFar = 1e9F;
  std::vector<float> out(grid.cells.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = grid.cells[i] == navigate::kLethalCost ? 0 : kFar;
  const auto pass = [&](std::size_t start, std::size_t stride, int count) {
    std::vector<float> f(static_cast<std::size_t>(count));
    std::vector<int> apex(static_cast<std::size_t>(count));
    std::vector<double> from(static_cast<std::size_t>(count) + 1);
    for (std::size_t q = 0; q < f.size(); ++q) f[q] = out[start + q * stride];
    int k = 0;
    apex[0] = 0;
    from[0] = -1e18;
    from[1] = 1e18;
    const auto meet = [&](int q, int p) {
      const double fq = static_cast<double>(f[static_cast<std::size_t>(q)]);
      const double fp = static_cast<double>(f[static_cast<std::size_t>(p)]);
      return ((fq + 1.0 * q * q) - (fp + 1.0 * p * p)) / (2.0 * (q - p));
    };
    for (int q = 1; q < count; ++q) {
      double s = meet(q, apex[static_cast<std::size_t>(k)]);
      while (k > 0 && s <= from[static_cast<std::size_t>(k)])
        s = meet(q, apex[static_cast<std::size_t>(--k)]);
      if (s <= from[static_cast<std::size_t>(k)]) k = -1;
      apex[static_cast<std::size_t>(++k)] = q;
      from[static_cast<std::size_t>(k)] = k == 0 ? -1e18 : s;
      from[static_cast<std::size_t>(k) + 1] = 1e18;
    }
    k = 0;
    for (int q = 0; q < count; ++q) {
      while (from[static_cast<std::size_t>(k) + 1] < q) ++k;
      const int p = apex[static_cast<std::size_t>(k)];
      out[start + static_cast<std::size_t>(q) * stride] =
          static_cast<float>((q - p) * (q - p)) + f[static_cast<std::size_t>(p)];
    }
  };
  const auto width = static_cast<std::size_t>(grid.width);
  for (std::size_t column = 0; column < width; ++column) pass(column, width, grid.height);
  for (std::size_t row = 0; row < static_cast<std::size_t>(grid.height); ++row)
    pass(row * width, 1, grid.width);
  return out;
}

}  // namespace

CostGrid make_office_map(const OfficeParams& params, std::uint64_t seed) {
  return Office(params, seed).make();
}

CostGrid make_hall_map(int side_cells, std::uint64_t seed) {
  Rng rng(seed);
  CostGrid grid = navigate::make_cost_grid(side_cells, side_cells, kCell_m, {0, 0}, navigate::kFreeCost);
  draw_walls(grid, grid.box(), 3);
  const int count = side_cells * side_cells / (cells(9) * cells(9));
  for (int k = 0; k < count; ++k) {
    const Cell at{rng.integer(0, side_cells - 1), rng.integer(0, side_cells - 1)};
    const bool shelf = rng.chance(0.3);
    const int width = shelf ? cells(rng.uniform(2, 8)) : cells(0.5);
    fill(grid, {at, {at.column + width, at.row + cells(rng.uniform(0.4, 1.2))}}, navigate::kLethalCost);
  }
  return grid;
}

CostGrid make_maze_map(int side_cells, double corridor_m, std::uint64_t seed) {
  Rng rng(seed);
  CostGrid grid = navigate::make_cost_grid(side_cells, side_cells, kCell_m, {0, 0}, navigate::kLethalCost);
  constexpr int kWall = 3;
  const int pitch = cells(corridor_m) + kWall;
  const int side = (side_cells - kWall) / pitch;
  std::vector<int> seen(static_cast<std::size_t>(side * side), 0);
  std::vector<std::pair<int, int>> stack{{0, 0}};
  const auto open = [&](int column, int row, int wider, int higher) {
    const Cell at{kWall + column * pitch, kWall + row * pitch};
    fill(grid, {at, {at.column + pitch - kWall + wider * pitch, at.row + pitch - kWall + higher * pitch}},
         navigate::kFreeCost);
  };
  const auto id = [&](int column, int row) { return static_cast<std::size_t>(row * side + column); };
  seen[0] = 1;
  open(0, 0, 0, 0);
  constexpr std::pair<int, int> kSteps[4]{{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  while (!stack.empty()) {
    const auto [column, row] = stack.back();
    std::vector<std::pair<int, int>> next;
    for (const auto& step : kSteps) {
      const std::pair<int, int> to{column + step.first, row + step.second};
      const bool inside = to.first >= 0 && to.second >= 0 && to.first < side && to.second < side;
      if (inside && seen[id(to.first, to.second)] == 0) next.push_back(to);
    }
    if (next.empty()) {
      stack.pop_back();
      continue;
    }
    const auto to = next[static_cast<std::size_t>(rng.integer(0, static_cast<int>(next.size()) - 1))];
    seen[id(to.first, to.second)] = 1;
    open(std::min(column, to.first), std::min(row, to.second), std::abs(column - to.first),
         std::abs(row - to.second));
    stack.push_back(to);
  }
  for (int k = 0; k < side * side / 30; ++k)
    open(rng.integer(0, side - 2), rng.integer(0, side - 2), k % 2, 1 - k % 2);
  return grid;
}

void inflate(CostGrid& grid, double inscribed_m, double radius_m, double scaling_per_m) {
  grid.inflation = {inscribed_m, radius_m, scaling_per_m};
  grid.may_hold_unknown =
      std::find(grid.cells.begin(), grid.cells.end(), navigate::kUnknownCost) != grid.cells.end();
  const std::vector<float> squared = squared_distances(grid);
  for (std::size_t i = 0; i < squared.size(); ++i)
    if (grid.cells[i] < navigate::kLethalCost)
      grid.cells[i] = grid.inflation.cost_at(std::sqrt(static_cast<double>(squared[i])) * grid.resolution_m);
}

std::vector<Eigen::Vector2d> random_places(const CostGrid& costs, int count, std::uint64_t seed,
                                           double margin_m) {
  const Cost limit = costs.inflation.cost_at(costs.inflation.inscribed_radius_m + margin_m);
  std::vector<int> area(costs.cells.size(), -1);
  std::vector<std::size_t> largest;
  const auto width = static_cast<std::size_t>(costs.width);
  for (std::size_t first = 0; first < area.size(); ++first) {
    if (costs.cells[first] >= limit || area[first] >= 0) continue;
    std::vector<std::size_t> members{first};
    area[first] = 1;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (const std::size_t next :
           {members[k] + 1, members[k] - 1, members[k] + width, members[k] - width}) {
        if (next >= area.size() || area[next] >= 0 || costs.cells[next] >= limit) continue;
        area[next] = 1;
        members.push_back(next);
      }
    if (members.size() > largest.size()) largest.swap(members);
  }
  Rng rng(seed);
  std::vector<Eigen::Vector2d> places;
  if (largest.empty()) return places;
  places.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const auto at = largest[static_cast<std::size_t>(rng.integer(0, static_cast<int>(largest.size()) - 1))];
    places.push_back(costs.middle_of({static_cast<int>(at % width), static_cast<int>(at / width)}));
  }
  return places;
}

}  // namespace extperfc::benchmark
