#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

#include "mapping/scan_points.hpp"

namespace extperfc::mapping {

/// Surfaces seen from a few poses near each other: per small cell the mean of the points that fell into it
/// and of their normals. The sides of a thin wall stay apart, because a cell keeps the normals of one side
/// only. Memory grows with the surface that was seen. Coordinates are of the frame that scans are added in
/// [m].
class SurfaceMap {
 public:
  static constexpr float kCellM = 0.08F;

  struct Surface {
    Eigen::Vector2f mean{0, 0};
    Eigen::Vector2f normal{0, 0};  ///< of unit length, or zero: unknown
    float weight{0};               ///< points that make it up; 0: empty
  };

  /// Adds what a scan saw from `map_T_base`.
  void add(const ScanPoints& points, const Pose2& map_T_base);
  void clear();
  [[nodiscard]] bool empty() const { return tiles_.empty(); }

  /// The nearest surface within `reach_cells` cells whose normal goes with `normal` (either may be zero:
  /// unknown). Null when there is none.
  [[nodiscard]] const Surface* nearest(const Eigen::Vector2f& point, const Eigen::Vector2f& normal,
                                       int reach_cells) const;

  /// Column or row of the cell that a coordinate lies in.
  static int cell_index(float coordinate_m) {
    return static_cast<int>(std::floor(coordinate_m * (1.0F / kCellM)));
  }
  /// A box of cells around every surface; none when the map is empty.
  struct Cells {
    int first_column{0};
    int first_row{0};
    int columns{0};
    int rows{0};
  };
  [[nodiscard]] Cells cells() const {
    return {first_column_ * kTileCells, first_row_ * kTileCells, columns_ * kTileCells, rows_ * kTileCells};
  }
  /// Column and row of every surface, in unspecified order.
  template <typename Visitor>
  void visit_cells(const Visitor& visitor) const {
    for (int entry = 0; entry < columns_ * rows_; ++entry) {
      const std::int32_t tile = directory_[static_cast<std::size_t>(entry)];
      if (tile < 0) continue;
      const int column = (entry % columns_ + first_column_) * kTileCells;
      const int row = (entry / columns_ + first_row_) * kTileCells;
      for (std::uint64_t bits = seen_[static_cast<std::size_t>(tile)]; bits != 0; bits &= bits - 1)
        visitor(column + (lowest_bit(bits) & kMask), row + (lowest_bit(bits) >> kTileBits));
    }
  }

  /// Every surface, in unspecified order.
  template <typename Visitor>
  void visit(const Visitor& visitor) const {
    for (std::size_t tile = 0; tile < tiles_.size(); ++tile)
      visit_tile(static_cast<std::int32_t>(tile), visitor);
  }
  /// Every surface that may stand within `radius_m` of a point, and some beyond, in unspecified order.
  template <typename Visitor>
  void visit_about(const Eigen::Vector2f& point, float radius_m, const Visitor& visitor) const {
    const auto tile_index = [](float coordinate_m) { return cell_index(coordinate_m) >> kTileBits; };
    const float margin_m = radius_m + kCellM;  // cells and means are rounded
    const int left = std::max(0, tile_index(point.x() - margin_m) - first_column_);
    const int right = std::min(columns_ - 1, tile_index(point.x() + margin_m) - first_column_);
    const int bottom = std::max(0, tile_index(point.y() - margin_m) - first_row_);
    const int top = std::min(rows_ - 1, tile_index(point.y() + margin_m) - first_row_);
    for (int row = bottom; row <= top; ++row)
      for (int entry = row * columns_ + left; entry <= row * columns_ + right; ++entry)
        visit_tile(directory_[static_cast<std::size_t>(entry)], visitor);
  }

 private:
  static constexpr int kTileBits = 3;
  static constexpr int kTileCells = 1 << kTileBits;
  static_assert(kTileCells * kTileCells == 64, "a bit each");
  using Tile = std::array<Surface, kTileCells * kTileCells>;

  /// Index of the tile of a cell; -1: no surface was seen there.
  [[nodiscard]] std::int32_t tile_of(int column, int row) const {
    const int tile_column = (column >> kTileBits) - first_column_;
    const int tile_row = (row >> kTileBits) - first_row_;
    if (tile_column < 0 || tile_row < 0 || tile_column >= columns_ || tile_row >= rows_) return -1;
    const int entry = tile_row * columns_ + tile_column;
    return directory_[static_cast<std::size_t>(entry)];
  }
  static constexpr int kMask = kTileCells - 1;
  static int place_in_tile(int column, int row) { return (row & kMask) * kTileCells + (column & kMask); }

  template <typename Visitor>
  void visit_tile(std::int32_t tile, const Visitor& visitor) const {
    if (tile < 0) return;
    const auto index = static_cast<std::size_t>(tile);
    for (std::uint64_t bits = seen_[index]; bits != 0; bits &= bits - 1)
      visitor(tiles_[index][static_cast<std::size_t>(lowest_bit(bits))]);
  }
  /// Calls `visitor` with the surfaces of the cells [first, last] of a row. Inline, because nearest() takes
  /// most of the mapper's time. The bits of a tile skip empty cells, the majority.
  template <typename Visitor>
  void visit_row(int first, int last, int row, const Visitor& visitor) const {
    constexpr std::uint64_t kRow = (std::uint64_t{1} << kTileCells) - 1;
    for (int begin = first & ~kMask; begin <= last; begin += kTileCells) {
      const std::int32_t tile = tile_of(begin, row);
      if (tile < 0) continue;
      const int row_begin = place_in_tile(begin, row);
      std::uint64_t bits = seen_[static_cast<std::size_t>(tile)] >> row_begin & kRow;
      if (begin < first) bits &= kRow << (first - begin);
      if (begin + kMask > last) bits &= kRow >> (begin + kMask - last);
      for (; bits != 0; bits &= bits - 1) {
        const int cell = row_begin + lowest_bit(bits);
        visitor(tiles_[static_cast<std::size_t>(tile)][static_cast<std::size_t>(cell)]);
      }
    }
  }
  static int lowest_bit(std::uint64_t bits) { return __builtin_ctzll(bits); }

  /// The cell, which is to be given weight now.
  [[nodiscard]] Surface& make(int column, int row);
  void widen(int tile_column, int tile_row);

  int first_column_{0};  ///< of the directory, in tiles
  int first_row_{0};
  int columns_{0};
  int rows_{0};
  std::vector<std::int32_t> directory_;  ///< index of each tile, or -1
  std::vector<Tile> tiles_;
  std::vector<std::uint64_t> seen_;  ///< of each tile: a bit per cell whose weight is above 0
};

}  // namespace extperfc::mapping
