#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"

namespace extperfc::mapping {

/// Draws key frames into an occupancy grid by counting, for every cell, rays that ended there and rays that
/// went through (Probabilistic Robotics, section 9.2, as a counting model). Counts can be taken back exactly,
/// so a key frame that relaxing moved is redrawn alone. Memory grows with the explored area.
class MapRenderer {
 public:
  MapRenderer(double resolution_m, double occupied_threshold);

  /// Draws what is new and redraws what moved, as far as about `most_cells` cell updates go. True when
  /// everything stands where it belongs.
  bool update(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses, std::size_t most_cells);

  /// The map as it was drawn so far, with at most `most_tiles` tiles brought up to date: the rest follows
  /// with the next calls, until complete(). O(cells), most of it copying.
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> map(
      std::size_t most_tiles = std::numeric_limits<std::size_t>::max());
  [[nodiscard]] bool complete() const { return complete_; }

 private:
  static constexpr int kTileBits = 6;
  static constexpr int kTileCells = 1 << kTileBits;
  struct Count {
    std::uint32_t hits{0};
    std::uint32_t passes{0};
  };
  struct Tile {
    std::array<Count, kTileCells * kTileCells> counts{};
    bool changed{true};
  };

  /// Adds (+1) or takes back (-1) one key frame; the number of cells touched.
  std::size_t draw(const ScanPoints& points, const Pose2& map_T_base, int sign);
  std::size_t draw_ray(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hit, int sign);
  Count& cell(int column, int row);
  Tile& tile(int column, int row);
  void fit_grid();
  void copy_tile(int tile_column, int tile_row, const Tile& from);
  [[nodiscard]] std::int8_t value(const Count& count) const;

  double resolution_m_;
  double occupied_threshold_;
  std::vector<Pose2> drawn_;  ///< where each key frame was drawn
  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  Tile* last_tile_{nullptr};
  int last_tile_column_{0};
  int last_tile_row_{0};
  OccupancyGrid grid_;
  int first_tile_column_{0};  ///< of the grid
  int first_tile_row_{0};
  int left_tile_{0};  ///< of all tiles
  int right_tile_{0};
  int bottom_tile_{0};
  int top_tile_{0};
  bool complete_{true};
};

}  // namespace extperfc::mapping
