#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

#include "navigate/global/tile_pool.hpp"
#include "navigate/global/traversal.hpp"

namespace extperfc::navigate {

/// Square blocks of cells as nodes of a search, so that a search takes a 16th or a 64th of the nodes. The
/// cells of a block that hang together are a part; a block may have two parts, each a node (further ones
/// count to the second), and parts are neighbours where their cells touch: what is separated in the cells is
/// separated here. A block weighs as much as its cells in the mean. Points are in blocks. Node = (row * 2^15
/// + column) * 2 + part.
class BlockSpace {
 public:
  /// Forgets the last search. Both must live until the next call. block_cells: 2, 4 or 8.
  void begin(const CostGrid& grid, const Traversal& traversal, int block_cells);
  [[nodiscard]] int block_cells() const { return size_; }

  /// The part that holds a cell of the grid; -1: the cell is not admissible.
  [[nodiscard]] std::int32_t node_of(const Cell& cell);
  [[nodiscard]] static int column_of(std::int32_t node) { return (node >> 1) & ((1 << kBits) - 1); }
  [[nodiscard]] static int row_of(std::int32_t node) { return node >> (kBits + 1); }
  [[nodiscard]] static Eigen::Vector2d middle_of(std::int32_t node) {
    return {column_of(node) + 0.5, row_of(node) + 0.5};
  }
  [[nodiscard]] SearchNode& state(std::int32_t node) {
    const int column = column_of(node);
    const int row = row_of(node);
    return tile(column, row).nodes[offset(column, row)][node & 1];
  }

  /// Marks the blocks whose column and row differ by at most `reach` from those of a point's.
  void mark_near(const Eigen::Vector2d& point, int reach);

  /// offer(node, step's cost) for every neighbour.
  template <typename Offer>
  void for_neighbours(std::int32_t node, Offer offer);

  /// Integral of the weights along a line between nodes that lie at these points; infinite when it leaves
  /// what hangs together or exceeds `limit`. O(length).
  [[nodiscard]] double line_cost(std::int32_t node, const Eigen::Vector2d& from, std::int32_t other,
                                 const Eigen::Vector2d& to, double limit);

  [[nodiscard]] std::size_t bytes() const { return tiles_.bytes(); }

 private:
  using Mask = std::uint64_t;  ///< a bit for each cell of a block, row by row
  struct Block {
    std::array<Mask, 2> parts{};  ///< the second is empty unless the first is not
    float weight{0};
  };

  static constexpr int kBits = 15;
  static constexpr int kTileBits = 5;
  static constexpr int kSide = 1 << kTileBits;

  struct Tile {
    std::array<Block, kSide * kSide> blocks;
    std::array<std::array<SearchNode, 2>, kSide * kSide> nodes;
  };

  [[nodiscard]] static std::int32_t node_of(int column, int row, int part) {
    const auto block = (static_cast<std::uint32_t>(row) << kBits) | static_cast<std::uint32_t>(column);
    return static_cast<std::int32_t>((block << 1U) | static_cast<std::uint32_t>(part));
  }
  [[nodiscard]] static std::size_t offset(int column, int row) {
    return static_cast<std::size_t>(((row & (kSide - 1)) << kTileBits) | (column & (kSide - 1)));
  }
  [[nodiscard]] Tile& tile(int column, int row) {
    const int index = (row >> kTileBits) * tile_columns_ + (column >> kTileBits);
    const auto at = static_cast<std::size_t>(index);
    Tile* found = tiles_.find(at);
    return found != nullptr ? *found : make_tile(at);
  }
  /// An empty one outside.
  [[nodiscard]] const Block& block(int column, int row) {
    static const Block kOutside;
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return kOutside;
    return tile(column, row).blocks[offset(column, row)];
  }
  /// The cells of the next block that touch cells of this one, one step along a row or a column.
  [[nodiscard]] Mask across(Mask cells, int column_step, int row_step) const {
    const int last = size_ - 1;
    if (column_step > 0) return (cells >> last) & first_column_;
    if (column_step < 0) return (cells & first_column_) << last;
    return row_step > 0 ? cells >> (size_ * last) : (cells & first_row_) << (size_ * last);
  }
  /// Bit 0 and 1: the parts of `next` that touch the cells.
  [[nodiscard]] static unsigned touched(const Block& next, Mask cells) {
    return ((next.parts[0] & cells) != 0 ? 1U : 0U) | ((next.parts[1] & cells) != 0 ? 2U : 0U);
  }
  /// The cells of the parts in a set.
  [[nodiscard]] static Mask cells_of(const Block& block, unsigned parts) {
    return ((parts & 1U) != 0 ? block.parts[0] : 0) | ((parts & 2U) != 0 ? block.parts[1] : 0);
  }
  Tile& make_tile(std::size_t at);
  [[nodiscard]] bool is_free(const Cell& first) const;
  [[nodiscard]] Block make_block(const Cell& first) const;
  void split(Block& block, Mask cells) const;

  const CostGrid* grid_{nullptr};
  const Traversal* traversal_{nullptr};
  int size_{4};
  Mask first_column_{0};
  Mask first_row_{0};
  Mask all_{0};
  int width_{0};
  int height_{0};
  int tile_columns_{0};
  TilePool<Tile> tiles_;
};

template <typename Offer>
void BlockSpace::for_neighbours(std::int32_t node, Offer offer) {
  constexpr std::array<int, 5> kColumn{1, 0, -1, 0, 1};
  constexpr std::array<int, 5> kRow{0, 1, 0, -1, 0};
  constexpr auto kHalfDiagonal = static_cast<float>(M_SQRT1_2);
  const int column = column_of(node);
  const int row = row_of(node);
  const Block& here = block(column, row);
  const Mask cells = here.parts[node & 1];
  std::array<const Block*, 5> beside{};
  std::array<unsigned, 5> parts{};
  for (std::size_t k = 0; k < 4; ++k) {
    beside[k] = &block(column + kColumn[k], row + kRow[k]);
    parts[k] = touched(*beside[k], across(cells, kColumn[k], kRow[k]));
  }
  beside[4] = beside[0];
  parts[4] = parts[0];
  for (std::size_t k = 0; k < 4; ++k) {
    for (int part = 0; part < 2; ++part)
      if ((parts[k] >> part & 1U) != 0)
        offer(node_of(column + kColumn[k], row + kRow[k], part), 0.5F * (here.weight + beside[k]->weight));
    if ((parts[k] | parts[k + 1]) == 0) continue;
    const int to_column = column + kColumn[k] + kColumn[k + 1];
    const int to_row = row + kRow[k] + kRow[k + 1];
    const Block& beyond = block(to_column, to_row);
    const Mask reached = across(cells_of(*beside[k], parts[k]), kColumn[k + 1], kRow[k + 1]) |
                         across(cells_of(*beside[k + 1], parts[k + 1]), kColumn[k], kRow[k]);
    const unsigned diagonal = touched(beyond, reached);
    for (int part = 0; part < 2; ++part)
      if ((diagonal >> part & 1U) != 0)
        offer(node_of(to_column, to_row, part), kHalfDiagonal * (here.weight + beyond.weight));
  }
}

}  // namespace extperfc::navigate
