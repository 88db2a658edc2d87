#include "navigate/global/cell_space.hpp"

#include <algorithm>
#include <cmath>

#include "navigate/global/line_walk.hpp"

namespace extperfc::navigate {

namespace {

/// change(column, row) for the cells whose middle lies in the disc and which lie in the box.
template <typename Change>
void for_cells_of(const Disc& disc, const CellBox& box, Change change) {
  const int low = std::max(box.min.row, static_cast<int>(std::ceil(disc.middle.y() - disc.radius - 0.5)));
  const int high =
      std::min(box.max.row - 1, static_cast<int>(std::floor(disc.middle.y() + disc.radius - 0.5)));
  for (int row = low; row <= high; ++row) {
    const double across = row + 0.5 - disc.middle.y();
    const double reach = std::sqrt(std::max(0.0, disc.radius * disc.radius - across * across));
    const int first = static_cast<int>(std::ceil(disc.middle.x() - reach - 0.5));
    const int last = static_cast<int>(std::floor(disc.middle.x() + reach - 0.5));
    for (int column = std::max(first, box.min.column); column <= std::min(last, box.max.column - 1); ++column)
      change(column, row);
  }
}

bool is_hard(Cost cost, Cost last_hard) {
  return cost >= kLethalCost && cost <= last_hard;
}

/// A cell at `at` beside which a base's centre may stand.
bool borders_on_admissible(const Cost* at, std::ptrdiff_t stride) {
  return std::min(std::min(at[-1], at[1]), std::min(at[-stride], at[stride])) < kInscribedCost;
}

/// Vectorized: whether any hard cell of a row of `count` cells borders on admissible ones.
bool row_has_border(const Cost* cells, int count, std::ptrdiff_t stride, Cost last_hard) {
  unsigned found = 0;
  for (int c = 0; c < count; ++c) {
    const unsigned hard = static_cast<unsigned>(cells[c] >= kLethalCost) & (cells[c] <= last_hard);
    const unsigned beside = static_cast<unsigned>(cells[c - 1] < kInscribedCost) |
                            static_cast<unsigned>(cells[c + 1] < kInscribedCost) |
                            static_cast<unsigned>(cells[c - stride] < kInscribedCost) |
                            static_cast<unsigned>(cells[c + stride] < kInscribedCost);
    found |= hard & beside;
  }
  return found != 0;
}

}  // namespace

void CellSpace::begin(const CostGrid& grid, const Traversal& traversal) {
  grid_ = &grid;
  traversal_ = &traversal;
  width_ = grid.width;
  height_ = grid.height;
  tile_columns_ = (width_ + kSide - 1) / kSide;
  tiles_.begin(tile_columns_, (height_ + kSide - 1) / kSide);
}

CellSpace::Tile& CellSpace::make_tile(std::size_t at) {
  Tile& made = tiles_.make(at);
  made.nodes.fill({});
  const int index = static_cast<int>(at);
  const Cell first{(index % tile_columns_) * kSide, (index / tile_columns_) * kSide};
  const int columns = std::min(kSide, width_ - first.column);
  const int rows = std::min(kSide, height_ - first.row);
  if (columns < kSide || rows < kSide) made.weight.fill(0);
  for (int row = 0; row < rows; ++row) {
    const Cost* from = grid_->cells.data() + grid_->index({first.column, first.row + row});
    float* to = made.weight.data() + offset(0, row);
    for (int column = 0; column < columns; ++column) to[column] = traversal_->weight[from[column]];
  }
  keep_distance(made, first);
  apply_discs(made, first);
  return made;
}

/// Lethal cells are surrounded by inscribed ones where a layer inflated them. Those that border on admissible
/// cells, and unknown cells, get discs of the inscribed radius here.
void CellSpace::keep_distance(Tile& tile, const Cell& first) const {
  const CellBox own{first, {first.column + kSide, first.row + kSide}};
  const CellBox box = own.grown(static_cast<int>(std::floor(traversal_->inscribed_cells)))
                          .clipped({{1, 1}, {width_ - 1, height_ - 1}});
  const auto stride = static_cast<std::ptrdiff_t>(width_);
  const Cost last_hard = traversal_->admits(kUnknownCost) ? kLethalCost : kUnknownCost;
  for (int row = box.min.row; row < box.max.row; ++row) {
    const Cost* cells = grid_->cells.data() + grid_->index({0, row});
    if (!row_has_border(cells + box.min.column, box.max.column - box.min.column, stride, last_hard)) continue;
    for (int column = box.min.column; column < box.max.column; ++column) {
      if (!is_hard(cells[column], last_hard) || !borders_on_admissible(cells + column, stride)) continue;
      for_cells_of({{column + 0.5, row + 0.5}, traversal_->inscribed_cells}, own,
                   [&](int c, int r) { tile.weight[offset(c, r)] = 0; });
    }
  }
}

void CellSpace::apply_discs(Tile& tile, const Cell& first) const {
  const CellBox own = CellBox{first, {first.column + kSide, first.row + kSide}}.clipped(grid_->box());
  const float dearest = traversal_->weight[kInscribedCost - 1];
  for (const Disc& disc : traversal_->opened)
    for_cells_of(disc, own, [&](int column, int row) {
      const Cost cost = grid_->at({column, row});
      float& weight = tile.weight[offset(column, row)];
      if (weight == 0 && (cost == kInscribedCost || traversal_->admits(cost))) weight = dearest;
    });
  for (const Disc& disc : traversal_->closed)
    for_cells_of(disc, own, [&](int column, int row) { tile.weight[offset(column, row)] = 0; });
}

double CellSpace::line_cost(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double limit) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto inside = [this](const Eigen::Vector2d& point) {
    return point.x() >= 0 && point.y() >= 0 && point.x() < width_ && point.y() < height_;
  };
  if (!inside(from) || !inside(to)) return kInfinite;
  int column = static_cast<int>(from.x());
  int row = static_cast<int>(from.y());
  int tile_column = column >> kTileBits;
  int tile_row = row >> kTileBits;
  const Tile* current = &tile(column, row);
  const auto weight_at = [&](int c, int r) {  // lines stay in a tile for many cells
    if (c >> kTileBits != tile_column || r >> kTileBits != tile_row) {
      tile_column = c >> kTileBits;
      tile_row = r >> kTileBits;
      current = &tile(c, r);
    }
    return current->weight[offset(c, r)];
  };
  double cost = 0;
  const auto visit = [&](int column_step, int row_step, double length) {
    const float here = weight_at(column, row);
    cost += length * static_cast<double>(here);
    column += column_step;
    row += row_step;
    return here > 0 && cost <= limit;
  };
  const auto corner = [&](int, int row_step) { return weight(column, row + row_step) > 0; };
  return walk_line(from, to, visit, corner) ? cost : kInfinite;
}

}  // namespace extperfc::navigate
