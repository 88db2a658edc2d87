#pragma once

#include <nav_msgs/OccupancyGrid.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::ros_convert {

[[nodiscard]] nav_msgs::OccupancyGrid to_message(const OccupancyGrid& map, const std_msgs::Header& header);

/// Errors: no cells, data of another length than width * height, a resolution that is not positive, an origin
/// that is not finite or not flat on the floor.
[[nodiscard]] Result<OccupancyGrid> to_occupancy_grid(const nav_msgs::OccupancyGrid& message);

}  // namespace extperfc::ros_convert
