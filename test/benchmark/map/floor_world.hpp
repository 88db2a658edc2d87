#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "extperfc/base/rng.hpp"

namespace extperfc::benchmark {

/// A floor plan of a whole building [m]: walls along x or y around a floor that is put together from
/// rectangles. Rays are cast through a grid, so that hundreds of walls cost little.
class FloorWorld {
 public:
  /// Corners in any order.
  void add_floor(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite);
  /// Four walls on the floor; corners in any order.
  void add_box(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite);
  /// Walls around the union of the floor, and the grid: once, after everything was added. Of the walls, this
  /// fraction in [0, 1] is glass, in pieces of 1 to 3 m.
  void close(double glass_fraction, Rng& rng);

  struct Hit {
    double range_m{std::numeric_limits<double>::infinity()};  ///< infinity: no wall
    bool glass{false};
  };
  /// The nearest wall, looked for up to `max_range_m` and a cell farther. From a place outside of the
  /// building: none. O(cells and their walls on the ray).
  [[nodiscard]] Hit cast(const Eigen::Vector2d& from, double angle_rad, double max_range_m) const;

  /// Whether a rectangle of the floor holds the point, this far from the rectangle's sides.
  [[nodiscard]] bool is_floor(const Eigen::Vector2d& point, double margin_m) const;

 private:
  struct Wall {
    int along;  // its axis: 0 for x, 1 for y
    double at;  // on the other axis
    double from;
    double to;
    bool glass;
  };
  struct Side {  // of a rectangle of the floor
    int along;
    bool high;
  };

  void add_wall(const Wall& wall);
  void wall_in(const Eigen::AlignedBox2d& area, Side side, double glass_fraction, Rng& rng);
  void add_stretch(Wall wall, double glass_fraction, Rng& rng);
  void build_grid();
  void meet(const std::vector<Wall>& walls, const Eigen::Vector2d& from, const Eigen::Vector2d& direction,
            Hit& nearest) const;
  [[nodiscard]] Eigen::Vector2i cell_of(const Eigen::Vector2d& point) const;
  [[nodiscard]] bool has_cell(const Eigen::Vector2i& cell) const;
  [[nodiscard]] std::size_t index(const Eigen::Vector2i& cell) const;

  std::vector<Eigen::AlignedBox2d> floor_;
  std::vector<Wall> walls_;
  std::vector<std::vector<Wall>> cells_;  // row by row
  Eigen::Vector2d low_{0, 0};             // of the grid
  Eigen::Vector2i size_{0, 0};            // of the grid, in cells
};

}  // namespace extperfc::benchmark
