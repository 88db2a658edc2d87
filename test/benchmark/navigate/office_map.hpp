#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"

namespace extperfc::benchmark {

struct OfficeParams {
  int width{2000};   ///< cells
  int height{2000};  ///< cells
  double resolution_m{0.05};
  double clutter{0.03};       ///< fraction of a floor that desks, boxes and columns cover
  double open_fraction{0.1};  ///< of the wings that are one hall
};

/// One floor from a seed: a ring of corridors and crossing ones, wings with rooms of 2.5 to 9 m between them,
/// doors of 0.8 to 1.2 m (some rooms have two), clutter that leaves 1.3 m to the walls in front of doors.
/// Cells are kFreeCost or kLethalCost, not inflated; the outer wall is closed.
[[nodiscard]] navigate::CostGrid make_office_map(const OfficeParams& params, std::uint64_t seed);

/// One hall with columns and shelves.
[[nodiscard]] navigate::CostGrid make_hall_map(int side_cells, std::uint64_t seed);

/// A perfect maze (one path between any two of its places, apart from a few opened walls) with corridors of
/// `corridor_m`.
[[nodiscard]] navigate::CostGrid make_maze_map(int side_cells, double corridor_m, std::uint64_t seed);

/// costmap_2d's inflation: kInscribedCost up to the inscribed radius, then 252 * exp(-scaling * (distance -
/// inscribed)) up to `radius_m`; distances between the middles of cells, exact. O(cells).
void inflate(navigate::CostGrid& grid, double inscribed_m, double radius_m, double scaling_per_m);

/// Middles of cells in the largest area that a circle margin_m wider than the inscribed one may enter.
[[nodiscard]] std::vector<Eigen::Vector2d> random_places(const navigate::CostGrid& costs, int count,
                                                         std::uint64_t seed, double margin_m = 0);

}  // namespace extperfc::benchmark
