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
#include "mapping/map_image.hpp"

namespace extperfc::mapping {

/// Draws key frames into an occupancy grid by counting, for every cell, rays that ended there and rays that
/// went through (Probabilistic Robotics, section 9.2, as a counting model). Counts can be taken back exactly,
/// so a key frame that an optimization moved is redrawn alone. Memory grows with the area that the map shows.
class MapRenderer {
 public:
  /// Bounds of the work of one call of map().
  struct MapBounds {
    std::size_t tiles{std::numeric_limits<std::size_t>::max()};         ///< brought up to date
    std::size_t copied_cells{std::numeric_limits<std::size_t>::max()};  ///< of an image
  };

  MapRenderer(double resolution_m, double occupied_threshold);

  /// Draws new key frames and redraws moved ones, with about `max_cells` cell updates at most. True when no
  /// key frame is left to draw.
  bool update(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses, std::size_t max_cells);

  /// Takes back a key frame, before its points are dropped. The number of cells touched.
  std::size_t forget(std::size_t frame, const ScanPoints& points);

  /// The map as drawn so far, within the bounds; the next calls add the rest, until complete(). O(changed
  /// cells); O(cells) where the extent grew or the last map is still in use, spread over several calls by the
  /// bounds. A map that takes several calls to copy lags until then.
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> map(const MapBounds& bounds);
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> map() { return map(MapBounds()); }
  [[nodiscard]] bool complete() const { return complete_; }

  /// Memory of the counts [bytes].
  [[nodiscard]] std::size_t counts_size() const;

 private:
  static constexpr int kTileBits = 6;
  static constexpr int kTileCells = 1 << kTileBits;
  static constexpr int kTileMask = kTileCells - 1;
  template <typename Number>
  struct Count {
    Number hits{0};
    Number passes{0};
  };
  template <typename Number>
  using Counts = std::array<Count<Number>, kTileCells * kTileCells>;
  /// Where few rays pass, a byte counts them: those that stray behind the walls of a building touch many
  /// tiles.
  struct Tile {
    static constexpr int kFewRays = 250;

    int column{0};
    int row{0};
    bool changed{false};                        ///< since it was drawn to the image
    int rays{0};                                ///< that touch it: no cell counts more
    std::unique_ptr<Counts<std::uint8_t>> few;  ///< at most one of the two; none while no ray touches it
    std::unique_ptr<Counts<std::uint32_t>> many;

    [[nodiscard]] bool in_use() const { return few != nullptr || many != nullptr; }
    void add_ray(int sign);  ///< before its cells are counted
    void release();          ///< the counts, if no ray is left
  };

  /// Adds (+1) or takes back (-1) one key frame; the number of cells touched.
  std::size_t draw(const ScanPoints& points, const Pose2& map_T_base, int sign);
  std::size_t draw_ray(const Eigen::Vector2d& from, const Eigen::Vector2d& to, bool hit, int sign);
  Tile& tile(int tile_column, int tile_row);
  [[nodiscard]] MapImage::Extent extent() const;
  void draw_changed_tiles(std::size_t max_tiles);
  void draw_tile(const Tile& tile);
  template <typename Number>
  void draw_cells(const Counts<Number>& counts, int row, std::int8_t* cells) const;

  double resolution_m_;
  double occupied_threshold_;
  std::vector<Pose2> drawn_;  ///< where each key frame was drawn
  std::unordered_map<std::uint64_t, std::unique_ptr<Tile>> tiles_;
  Tile* last_tile_{nullptr};
  int last_tile_column_{0};
  int last_tile_row_{0};
  std::vector<Tile*> changed_tiles_;  ///< in the order of their first change
  MapImage image_;
  int left_tile_{0};  ///< of all tiles
  int right_tile_{0};
  int bottom_tile_{0};
  int top_tile_{0};
  bool complete_{true};
};

}  // namespace extperfc::mapping
