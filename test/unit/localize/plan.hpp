#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::localize {

/// A building as walls without thickness. Scans are cast against the walls themselves, not against the map
/// that is drawn from them.
struct Plan {
  struct Wall {
    double x0, y0, x1, y1;
  };
  double width_m{0};
  double height_m{0};
  std::vector<Wall> walls;

  /// Four walls.
  void box(double x0, double y0, double x1, double y1) {
    walls.push_back({x0, y0, x1, y0});
    walls.push_back({x1, y0, x1, y1});
    walls.push_back({x1, y1, x0, y1});
    walls.push_back({x0, y1, x0, y0});
  }

  [[nodiscard]] double cast(double x, double y, double angle) const {
    double nearest = std::numeric_limits<double>::infinity();
    const double dx = std::cos(angle);
    const double dy = std::sin(angle);
    for (const Wall& w : walls) {
      const double ex = w.x1 - w.x0;
      const double ey = w.y1 - w.y0;
      const double cross = dx * ey - dy * ex;
      if (std::abs(cross) < 1e-12) continue;
      const double range = ((w.x0 - x) * ey - (w.y0 - y) * ex) / cross;
      const double along = ((w.x0 - x) * dy - (w.y0 - y) * dx) / cross;
      if (range > 0 && along >= 0 && along <= 1) nearest = std::min(nearest, range);
    }
    return nearest;
  }

  /// Everything that is no wall is free. The plan's (0, 0) stands at `origin` in the map, half a cell inside
  /// the grid's corner, so that walls at multiples of the resolution run through the middles of cells.
  [[nodiscard]] std::shared_ptr<OccupancyGrid> map(const Pose2& origin = {},
                                                   double resolution_m = 0.05) const {
    auto grid = std::make_shared<OccupancyGrid>();
    grid->resolution_m = resolution_m;
    grid->origin = compose(origin, {-resolution_m / 2, -resolution_m / 2, 0});
    grid->width = static_cast<std::size_t>(std::ceil(width_m / resolution_m)) + 1;
    grid->height = static_cast<std::size_t>(std::ceil(height_m / resolution_m)) + 1;
    grid->cells.assign(grid->width * grid->height, OccupancyGrid::kFree);
    for (const Wall& w : walls) {
      const int steps = static_cast<int>(4 * std::hypot(w.x1 - w.x0, w.y1 - w.y0) / resolution_m) + 1;
      for (int i = 0; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        const auto column = static_cast<std::size_t>((w.x0 + t * (w.x1 - w.x0)) / resolution_m + 0.5);
        const auto row = static_cast<std::size_t>((w.y0 + t * (w.y1 - w.y0)) / resolution_m + 0.5);
        grid->cells[row * grid->width + column] = OccupancyGrid::kOccupied;
      }
    }
    return grid;
  }

  /// A revolution of `rays` rays from a scanner that sits off the robot's middle; noise of 1 cm.
  [[nodiscard]] LaserScan scan(const Pose2& plan_T_base, Rng& rng, std::size_t rays = 180) const {
    LaserScan scan;
    scan.angle_min = -M_PI;
    scan.angle_increment = 2 * M_PI / static_cast<double>(rays);
    scan.range_min = 0.1;
    scan.range_max = 12;
    scan.base_T_sensor = {0.2, 0.05, 0.3};
    const Pose2 sensor = compose(plan_T_base, scan.base_T_sensor);
    for (std::size_t i = 0; i < rays; ++i) {
      const double angle = sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double range = cast(sensor.x, sensor.y, angle);
      scan.ranges.push_back(range > scan.range_max ? std::numeric_limits<float>::infinity()
                                                   : static_cast<float>(range + rng.normal(0, 0.01)));
    }
    return scan;
  }
};

/// A room of 10 x 8 m that looks different from everywhere.
inline Plan room() {
  Plan plan{10, 8, {}};
  plan.box(0.1, 0.1, 9.9, 7.9);
  plan.box(2, 5.5, 3.2, 6.3);
  plan.box(7, 1, 7.6, 2.8);
  plan.walls.push_back({0.1, 3, 1.5, 3});
  plan.walls.push_back({6, 7.9, 6, 6.4});
  return plan;
}

/// 24 x 14 m: a corridor between two rows of six rooms each. The rooms are alike but for what stands in some
/// of them.
inline Plan building() {
  Plan plan{24, 14, {}};
  plan.box(0.1, 0.1, 23.9, 13.9);
  for (int side = 0; side < 2; ++side) {
    const double wall = side == 0 ? 5.8 : 8.2;
    const double far = side == 0 ? 0.1 : 13.9;
    for (int i = 0; i < 6; ++i) {
      const double left = 0.1 + i * 23.8 / 6;
      const double right = 0.1 + (i + 1) * 23.8 / 6;
      plan.walls.push_back({left, wall, left + 1.2, wall});  // a door of 1 m
      plan.walls.push_back({left + 2.2, wall, right, wall});
      if (i > 0) plan.walls.push_back({left, wall, left, far});
    }
  }
  plan.box(1, 2, 2, 3);
  plan.box(9, 1, 10.2, 1.8);
  plan.box(13.5, 3, 14.1, 4.4);
  plan.box(5, 11, 6.5, 11.6);
  plan.box(17, 12, 18, 13);
  plan.walls.push_back({21, 13.9, 21, 11});
  plan.walls.push_back({11, 10, 10, 11});
  return plan;
}

/// Distance [m] and rotation [rad] between two poses.
inline double apart_m(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}
inline double apart_rad(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw));
}

}  // namespace extperfc::localize
