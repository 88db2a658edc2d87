#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

#include "navigate/global/tile_pool.hpp"
#include "navigate/global/traversal.hpp"

namespace extperfc::navigate {

/// The cells of a cost grid as nodes of a search: steps to the eight neighbours, a diagonal one only between
/// two admissible cells. Points are in cells: cell (0, 0) reaches from (0, 0) to (1, 1). Node = row * 2^15 +
/// column.
class CellSpace {
 public:
  /// Forgets the last search. Both must live until the next call.
  void begin(const CostGrid& grid, const Traversal& traversal);

  [[nodiscard]] static std::int32_t node_of(int column, int row) {
    return static_cast<std::int32_t>((static_cast<std::uint32_t>(row) << kBits) |
                                     static_cast<std::uint32_t>(column));
  }
  [[nodiscard]] static int column_of(std::int32_t node) { return node & ((1 << kBits) - 1); }
  [[nodiscard]] static int row_of(std::int32_t node) { return node >> kBits; }
  [[nodiscard]] static Eigen::Vector2d middle_of(std::int32_t node) {
    return {column_of(node) + 0.5, row_of(node) + 0.5};
  }

  [[nodiscard]] SearchNode& state(std::int32_t node) {
    const int column = column_of(node);
    const int row = row_of(node);
    return tile(column, row).nodes[offset(column, row)];
  }
  /// Cost per cell of length; 0: not admissible or outside.
  [[nodiscard]] float weight(int column, int row) {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return 0;
    return tile(column, row).weight[offset(column, row)];
  }

  /// offer(node, step's cost) for every neighbour.
  template <typename Offer>
  void for_neighbours(std::int32_t node, Offer offer);

  /// Integral of the weights along a line between two points; infinite when it leaves what is admissible or
  /// exceeds `limit`. O(length).
  [[nodiscard]] double line_cost(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                 double limit = std::numeric_limits<double>::infinity());
  /// The same between two nodes that lie at these points.
  [[nodiscard]] double line_cost(std::int32_t /*node*/, const Eigen::Vector2d& from, std::int32_t /*other*/,
                                 const Eigen::Vector2d& to, double limit) {
    return line_cost(from, to, limit);
  }

  [[nodiscard]] std::size_t bytes() const { return tiles_.bytes(); }

 private:
  static constexpr int kBits = 15;
  static constexpr int kTileBits = 6;
  static constexpr int kSide = 1 << kTileBits;

  struct Tile {
    std::array<float, kSide * kSide> weight;
    std::array<SearchNode, kSide * kSide> nodes;
  };

  [[nodiscard]] static std::size_t offset(int column, int row) {
    return static_cast<std::size_t>(((row & (kSide - 1)) << kTileBits) | (column & (kSide - 1)));
  }
  [[nodiscard]] Tile& tile(int column, int row) {
    const int index = (row >> kTileBits) * tile_columns_ + (column >> kTileBits);
    const auto at = static_cast<std::size_t>(index);
    Tile* found = tiles_.find(at);
    return found != nullptr ? *found : make_tile(at);
  }
  Tile& make_tile(std::size_t at);
  void keep_distance(Tile& tile, const Cell& first) const;
  void apply_discs(Tile& tile, const Cell& first) const;

  const CostGrid* grid_{nullptr};
  const Traversal* traversal_{nullptr};
  int width_{0};
  int height_{0};
  int tile_columns_{0};
  TilePool<Tile> tiles_;
};

template <typename Offer>
void CellSpace::for_neighbours(std::int32_t node, Offer offer) {
  // Around the cell: right, up, left, down; between two of them the diagonal.
  constexpr std::array<int, 5> kColumn{1, 0, -1, 0, 1};
  constexpr std::array<int, 5> kRow{0, 1, 0, -1, 0};
  constexpr auto kHalfDiagonal = static_cast<float>(M_SQRT1_2);
  const int column = column_of(node);
  const int row = row_of(node);
  const float here = weight(column, row);
  std::array<float, 5> beside{};
  for (std::size_t k = 0; k < 4; ++k) beside[k] = weight(column + kColumn[k], row + kRow[k]);
  beside[4] = beside[0];
  for (std::size_t k = 0; k < 4; ++k) {
    if (beside[k] == 0) continue;
    offer(node_of(column + kColumn[k], row + kRow[k]), 0.5F * (here + beside[k]));
    if (beside[k + 1] == 0) continue;
    const int to_column = column + kColumn[k] + kColumn[k + 1];
    const int to_row = row + kRow[k] + kRow[k + 1];
    const float beyond = weight(to_column, to_row);
    if (beyond > 0) offer(node_of(to_column, to_row), kHalfDiagonal * (here + beyond));
  }
}

}  // namespace extperfc::navigate
