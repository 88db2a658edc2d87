#include "extperfc/navigate/inflation_layer.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kRounding = 1e-9;
constexpr int kNoObstacle = 1 << 20;  // [cells]

/// For each cell of `box` with its columns those of `from`: rows to the nearest lethal cell of `from` in the
/// same column, kNoObstacle or more without one. Row by row.
std::vector<int> rows_to_lethal(const std::vector<std::uint8_t>& lethal, const CostGrid& grid,
                                const CellBox& box, const CellBox& from) {
  const auto width = static_cast<std::size_t>(from.max.column - from.min.column);
  std::vector<int> result(static_cast<std::size_t>(box.max.row - box.min.row) * width, kNoObstacle);
  const auto sweep = [&](int begin, int end, int step) {
    std::vector<int> rows_since(width, kNoObstacle);
    for (int row = begin; row != end; row += step) {
      const std::uint8_t* cells = &lethal[grid.index({from.min.column, row})];
      for (std::size_t i = 0; i < width; ++i) rows_since[i] = cells[i] != 0 ? 0 : rows_since[i] + 1;
      if (row < box.min.row || row >= box.max.row) continue;
      int* nearest = &result[static_cast<std::size_t>(row - box.min.row) * width];
      for (std::size_t i = 0; i < width; ++i) nearest[i] = std::min(nearest[i], rows_since[i]);
    }
  };
  sweep(from.min.row, box.max.row, 1);
  sweep(from.max.row - 1, box.min.row - 1, -1);
  return result;
}

/// The lower envelope of the parabolas (column - c)^2 + rows(c)^2 of one row: squared distances to the
/// nearest lethal cell [cells^2]. Meijster's second phase.
class Envelope {
 public:
  explicit Envelope(int width) : width_(width) { sites_.reserve(static_cast<std::size_t>(width)); }

  /// Of the columns with at most `reach` rows.
  void build(const int* rows, int reach) {
    sites_.clear();
    for (int column = 0; column < width_; ++column) {
      if (rows[column] > reach) continue;
      const int square = rows[column] * rows[column];
      while (!sites_.empty() &&
             at(sites_.back(), sites_.back().begin) > at({column, square, 0}, sites_.back().begin))
        sites_.pop_back();
      if (sites_.empty()) {
        sites_.push_back({column, square, 0});
        continue;
      }
      const Site& last = sites_.back();
      const int twice_gap = 2 * (column - last.column);
      const int begin = 1 + (column * column - last.column * last.column + square - last.square) / twice_gap;
      if (begin < width_) sites_.push_back({column, square, begin});
    }
  }
  [[nodiscard]] bool empty() const { return sites_.empty(); }

  /// Calls `visit(column, squared distance)` for the columns from `end` - 1 down to `begin`.
  template <typename Visit>
  void visit_down(int begin, int end, const Visit& visit) const {
    std::size_t i = sites_.size() - 1;
    for (int column = end - 1; column >= begin; --column) {
      while (sites_[i].begin > column) --i;
      visit(column, at(sites_[i], column));
    }
  }

 private:
  struct Site {
    int column;
    int square;
    int begin;  ///< first column for which it is the nearest
  };
  static int at(const Site& site, int column) {
    return (column - site.column) * (column - site.column) + site.square;
  }

  int width_;
  std::vector<Site> sites_;
};

}  // namespace

InflationLayer::InflationLayer(const Inflation& inflation) {
  set(inflation);
}

void InflationLayer::set(const Inflation& inflation) {
  constexpr double kMaxRadius = 10;
  demand(inflation.inscribed_radius_m >= 0 && inflation.inscribed_radius_m <= inflation.radius_m &&
             inflation.radius_m <= kMaxRadius,
         "inflation: 0 <= inscribed radius <= inflation radius <= 10 m must hold");
  demand(inflation.cost_scaling_factor >= 0 && std::isfinite(inflation.cost_scaling_factor),
         "inflation: cost_scaling_factor must be finite and 0 or more");
  inflation_ = inflation;
  table_.clear();
  changed_ = true;
}

int InflationLayer::reach_cells(const CostGrid& grid) const {
  const int longest = std::max(grid.width, grid.height);
  return static_cast<int>(std::min<double>(longest, inflation_.radius_m / grid.resolution_m + kRounding));
}

void InflationLayer::match(const CostGrid& grid) {
  lethal_.assign(grid.cells.size(), 0);
  table_.clear();
  changed_ = true;
}

CellBox InflationLayer::take_changes(const CostGrid& grid, double /*now_s*/) {
  if (!changed_) return {};
  changed_ = false;
  return grid.box();
}

void InflationLayer::fill_table(const CostGrid& grid) {
  const int reach = reach_cells(grid);
  const double radius = std::min<double>(inflation_.radius_m / grid.resolution_m, reach + 1) + kRounding;
  const auto count = static_cast<std::size_t>(square(radius)) + 1;
  table_.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    table_.push_back(inflation_.cost_at(std::sqrt(static_cast<double>(i)) * grid.resolution_m));
}

void InflationLayer::note_lethal(const CostGrid& grid, const CellBox& box) {
  for (int row = box.min.row; row < box.max.row; ++row) {
    const Cost* cells = &grid.cells[grid.index({box.min.column, row})];
    std::transform(cells, cells + (box.max.column - box.min.column),
                   &lethal_[grid.index({box.min.column, row})],
                   [](Cost cost) { return static_cast<std::uint8_t>(cost == kLethalCost ? 1 : 0); });
  }
}

void InflationLayer::write(CostGrid& grid, const CellBox& box) {
  if (table_.empty()) fill_table(grid);
  note_lethal(grid, box);
  const int reach = reach_cells(grid);
  const CellBox from = box.grown(reach).clipped(grid.box());
  const auto rows = rows_to_lethal(lethal_, grid, box, from);
  const int width = from.max.column - from.min.column;
  Envelope envelope(width);
  for (int row = box.min.row; row < box.max.row; ++row) {
    envelope.build(&rows[static_cast<std::size_t>(row - box.min.row) * static_cast<std::size_t>(width)],
                   reach);
    if (envelope.empty()) continue;
    Cost* cells = &grid.cells[grid.index({from.min.column, row})];
    envelope.visit_down(
        box.min.column - from.min.column, box.max.column - from.min.column, [&](int column, int squared) {
          if (static_cast<std::size_t>(squared) < table_.size() && cells[column] != kUnknownCost)
            cells[column] = std::max(cells[column], table_[static_cast<std::size_t>(squared)]);
        });
  }
  grid.inflation = inflation_;
}

}  // namespace extperfc::navigate
