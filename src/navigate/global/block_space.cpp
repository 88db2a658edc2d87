#include "navigate/global/block_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "navigate/global/line_walk.hpp"

namespace extperfc::navigate {

void BlockSpace::begin(const CostGrid& grid, const Traversal& traversal, int block_cells) {
  grid_ = &grid;
  traversal_ = &traversal;
  size_ = block_cells;
  first_row_ = (Mask{1} << block_cells) - 1;
  first_column_ = 0;
  for (int row = 0; row < block_cells; ++row) first_column_ |= Mask{1} << (row * block_cells);
  all_ = first_row_ * first_column_;
  width_ = (grid.width + block_cells - 1) / block_cells;
  height_ = (grid.height + block_cells - 1) / block_cells;
  tile_columns_ = (width_ + kSide - 1) / kSide;
  tiles_.begin(tile_columns_, (height_ + kSide - 1) / kSide);
}

BlockSpace::Tile& BlockSpace::make_tile(std::size_t at) {
  Tile& made = tiles_.make(at);
  made.nodes.fill({});
  const int index = static_cast<int>(at);
  const Cell first{(index % tile_columns_) * kSide, (index / tile_columns_) * kSide};
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column)
      made.blocks[offset(column, row)] =
          make_block({(first.column + column) * size_, (first.row + row) * size_});
  return made;
}

/// A whole block of kFreeCost, far from discs: the common case.
bool BlockSpace::is_free(const Cell& first) const {
  if (first.column + size_ > grid_->width || first.row + size_ > grid_->height) return false;
  Cost highest = 0;
  for (int row = 0; row < size_; ++row) {
    const Cost* costs = grid_->cells.data() + grid_->index({first.column, first.row + row});
    for (int column = 0; column < size_; ++column) highest = std::max(highest, costs[column]);
  }
  const Eigen::Vector2d middle(first.column + 0.5 * size_, first.row + 0.5 * size_);
  const auto beside = [&](const Disc& disc) { return Disc{disc.middle, disc.radius + size_}.holds(middle); };
  return highest == kFreeCost && std::none_of(traversal_->closed.begin(), traversal_->closed.end(), beside);
}

BlockSpace::Block BlockSpace::make_block(const Cell& first) const {
  Block block;
  Mask cells = 0;
  float sum = 0;
  float count = 0;
  if (is_free(first)) {
    block.parts[0] = all_;
    block.weight = traversal_->weight[kFreeCost];
    return block;
  }
  const CellBox box = CellBox{first, {first.column + size_, first.row + size_}}.clipped(grid_->box());
  for (int row = box.min.row; row < box.max.row; ++row) {
    const Cost* costs = grid_->cells.data() + grid_->index({0, row});
    for (int column = box.min.column; column < box.max.column; ++column) {
      const float weight = traversal_->weight[costs[column]];
      cells |= static_cast<Mask>(weight > 0) << ((row - first.row) * size_ + column - first.column);
      sum += weight;
      count += weight > 0 ? 1.0F : 0.0F;
    }
  }
  const Eigen::Vector2d middle(first.column + 0.5 * size_, first.row + 0.5 * size_);
  for (const Disc& disc : traversal_->opened)
    if (Disc{disc.middle, disc.radius + size_}.holds(middle))
      for (int k = 0; k < size_ * size_; ++k) {
        const Cell cell{first.column + k % size_, first.row + k / size_};
        if (!grid_->contains(cell) || !disc.holds({cell.column + 0.5, cell.row + 0.5})) continue;
        if (grid_->at(cell) == kInscribedCost) cells |= Mask{1} << k;
      }
  for (const Disc& disc : traversal_->closed)
    if (Disc{disc.middle, disc.radius + size_}.holds(middle))
      for (int k = 0; k < size_ * size_; ++k)
        if (const Cell cell{first.column + k % size_, first.row + k / size_};
            disc.holds({cell.column + 0.5, cell.row + 0.5}))
          cells &= ~(Mask{1} << k);
  if (cells == 0) return block;
  block.weight = count > 0 ? sum / count : traversal_->weight[kInscribedCost - 1];
  split(block, cells);
  return block;
}

/// The first part grows from the lowest bit over neighbours; the rest is the second.
void BlockSpace::split(Block& block, Mask cells) const {
  block.parts = {cells, 0};
  if (cells == all_) return;
  Mask part = cells & (~cells + 1);
  for (Mask last = 0; part != last;) {
    last = part;
    const Mask not_last_column = part & ~(first_column_ << (size_ - 1));
    const Mask not_first_column = part & ~first_column_;
    part |= (not_last_column << 1) | (not_first_column >> 1) | (part << size_) | (part >> size_);
    part &= cells;
  }
  block.parts = {part, cells & ~part};
}

std::int32_t BlockSpace::node_of(const Cell& cell) {
  const int column = cell.column / size_;
  const int row = cell.row / size_;
  const Mask bit = Mask{1} << ((cell.row % size_) * size_ + cell.column % size_);
  const unsigned parts = touched(block(column, row), bit);
  return parts == 0 ? -1 : node_of(column, row, parts == 1 ? 0 : 1);
}

void BlockSpace::mark_near(const Eigen::Vector2d& point, int reach) {
  const auto column = static_cast<int>(point.x());
  const auto row = static_cast<int>(point.y());
  for (int r = std::max(0, row - reach); r <= std::min(height_ - 1, row + reach); ++r)
    for (int c = std::max(0, column - reach); c <= std::min(width_ - 1, column + reach); ++c)
      for (SearchNode& node : tile(c, r).nodes[offset(c, r)]) node.near_path = true;
}

double BlockSpace::line_cost(std::int32_t node, const Eigen::Vector2d& from, std::int32_t other,
                             const Eigen::Vector2d& to, double limit) {
  int column = column_of(node);
  int row = row_of(node);
  unsigned parts = 1U << (node & 1);
  const Block* here = &block(column, row);
  double cost = 0;
  const auto visit = [&](int column_step, int row_step, double length) {
    cost += length * static_cast<double>(here->weight);
    if (cost > limit) return false;
    if (column_step == 0 && row_step == 0) return true;
    const Mask reached = across(cells_of(*here, parts), column_step, row_step);
    column += column_step;
    row += row_step;
    here = &block(column, row);
    parts = touched(*here, reached);
    return parts != 0;
  };
  const auto corner = [](int, int) { return true; };
  if (!walk_line(from, to, visit, corner)) return std::numeric_limits<double>::infinity();
  return (parts >> (other & 1) & 1U) != 0 ? cost : std::numeric_limits<double>::infinity();
}

}  // namespace extperfc::navigate
