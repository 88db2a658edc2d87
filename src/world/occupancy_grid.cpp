#include "extperfc/world/occupancy_grid.hpp"

#include <cmath>

namespace extperfc {

std::optional<OccupancyGrid::Cell> OccupancyGrid::cell_of(double x_m, double y_m) const {
  const double c = std::cos(origin.yaw);
  const double s = std::sin(origin.yaw);
  const double dx = x_m - origin.x;
  const double dy = y_m - origin.y;
  const double column = std::floor((c * dx + s * dy) / resolution_m);
  const double row = std::floor((-s * dx + c * dy) / resolution_m);
  // Written so that NaN is outside.
  if (!(column >= 0 && row >= 0 && column < static_cast<double>(width) && row < static_cast<double>(height)))
    return std::nullopt;
  return Cell{static_cast<std::size_t>(column), static_cast<std::size_t>(row)};
}

Pose2 OccupancyGrid::middle_of(Cell cell) const {
  return compose(origin, {(static_cast<double>(cell.column) + 0.5) * resolution_m,
                          (static_cast<double>(cell.row) + 0.5) * resolution_m, 0});
}

}  // namespace extperfc
