#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate {

inline constexpr std::int8_t kUnknownCell = -1;
inline constexpr std::int8_t kFreeCell = 0;
inline constexpr std::int8_t kOccupiedCell = 100;

/// Grid over a world's floor plan, with the numbers of nav_msgs/OccupancyGrid. Row by row from the lowest y;
/// cell (0, 0) has its lower left corner at origin_m.
struct FloorPlan {
  int width{0};   ///< cells along x
  int height{0};  ///< cells along y
  double resolution_m{0};
  Eigen::Vector2d origin_m{0, 0};  ///< world frame
  std::vector<std::int8_t> data;   ///< kUnknownCell, kFreeCell or kOccupiedCell

  [[nodiscard]] std::int8_t at(int column, int row) const {
    return data[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(column)];
  }
};

/// The true map: a cell is occupied when its square shares area with the shadow of the part of a fixed or
/// movable body that lies between the two heights. Loose bodies and people do not count. Cells that cannot be
/// reached from the robot's start without passing a fixed body are unknown (movable bodies, such as shut
/// doors, are passed). Error: a resolution that is not in [0.005, 1] m, heights out of order, more than 10^8
/// cells. O(cells + area of the bodies).
[[nodiscard]] Result<FloorPlan> floor_plan(const WorldSpec& world, double resolution_m, double z_min_m,
                                           double z_max_m);

}  // namespace extperfc::simulate
