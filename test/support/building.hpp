#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/math.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {

/// A box on the floor: a wall, a cupboard. Its axes need not be those of a grid.
struct FloorBox {
  Pose2 world_T_box;
  Eigen::Vector2d half_m{0.5, 0.5};
};

/// A round obstacle: a person seen from above.
struct FloorDisc {
  Eigen::Vector2d at_m{0, 0};
  double radius_m{0.25};
};

/// Ground truth of a floor: exact shapes, not cells.
struct Building {
  std::vector<FloorBox> boxes;
  Eigen::Vector2d size_m{0, 0};  ///< from the origin

  void add(double left, double bottom, double right, double top) {
    boxes.push_back({{(left + right) / 2, (bottom + top) / 2, 0}, {(right - left) / 2, (top - bottom) / 2}});
  }
  /// Walls of 0.1 m all around.
  void enclose() {
    add(0, 0, size_m.x(), 0.1);
    add(0, size_m.y() - 0.1, size_m.x(), size_m.y());
    add(0, 0, 0.1, size_m.y());
    add(size_m.x() - 0.1, 0, size_m.x(), size_m.y());
  }
};

/// Distance along a ray to a box or a disc [m]; infinity without a hit.
inline double ray_range(const FloorBox& box, const Eigen::Vector2d& from, const Eigen::Vector2d& direction) {
  const double c = std::cos(box.world_T_box.yaw);
  const double s = std::sin(box.world_T_box.yaw);
  const Eigen::Vector2d to(from.x() - box.world_T_box.x, from.y() - box.world_T_box.y);
  const std::array<double, 2> p{c * to.x() + s * to.y(), -s * to.x() + c * to.y()};
  const std::array<double, 2> d{c * direction.x() + s * direction.y(),
                                -s * direction.x() + c * direction.y()};
  double near = 0;
  double far = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double half = box.half_m[static_cast<Eigen::Index>(axis)];
    if (std::abs(d[axis]) < 1e-12) {
      if (std::abs(p[axis]) > half) return std::numeric_limits<double>::infinity();
      continue;
    }
    const double a = (-half - p[axis]) / d[axis];
    const double b = (half - p[axis]) / d[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far ? near : std::numeric_limits<double>::infinity();
}

inline double ray_range(const FloorDisc& disc, const Eigen::Vector2d& from,
                        const Eigen::Vector2d& direction) {
  const Eigen::Vector2d to = disc.at_m - from;
  const double along = to.dot(direction);
  const double rest = disc.radius_m * disc.radius_m - (to.squaredNorm() - along * along);
  if (rest < 0 || along < 0) return std::numeric_limits<double>::infinity();
  return std::max(0.0, along - std::sqrt(rest));
}

/// Whether a convex polygon and a box overlap (separating axes).
inline bool overlaps(const FloorBox& box, const std::vector<Eigen::Vector2d>& polygon_m) {
  const double c = std::cos(box.world_T_box.yaw);
  const double s = std::sin(box.world_T_box.yaw);
  const Eigen::Vector2d middle(box.world_T_box.x, box.world_T_box.y);
  const Eigen::Vector2d x_axis(c, s);
  const Eigen::Vector2d y_axis(-s, c);
  std::vector<Eigen::Vector2d> corners;
  corners.reserve(4);
  for (const double i : {-1.0, 1.0})
    for (const double j : {-1.0, 1.0})
      corners.emplace_back(middle + i * box.half_m.x() * x_axis + j * box.half_m.y() * y_axis);
  std::vector<Eigen::Vector2d> axes{x_axis, y_axis};
  axes.reserve(2 + polygon_m.size());
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d edge = polygon_m[(i + 1) % polygon_m.size()] - polygon_m[i];
    axes.emplace_back(-edge.y(), edge.x());
  }
  const auto extent = [](const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& axis) {
    std::array<double, 2> range{std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity()};
    for (const Eigen::Vector2d& point : points) {
      range[0] = std::min(range[0], point.dot(axis));
      range[1] = std::max(range[1], point.dot(axis));
    }
    return range;
  };
  return std::all_of(axes.begin(), axes.end(), [&](const Eigen::Vector2d& axis) {
    const auto a = extent(corners, axis);
    const auto b = extent(polygon_m, axis);
    return a[0] <= b[1] && b[0] <= a[1];
  });
}

inline std::vector<Eigen::Vector2d> placed(const std::vector<Eigen::Vector2d>& corners_m, const Pose2& pose) {
  std::vector<Eigen::Vector2d> result;
  result.reserve(corners_m.size());
  for (const Eigen::Vector2d& corner : corners_m) {
    const Pose2 at = compose(pose, {corner.x(), corner.y(), 0});
    result.emplace_back(at.x, at.y);
  }
  return result;
}

/// From a point to a polygon [m]; 0 inside a convex one.
inline double polygon_distance(const std::vector<Eigen::Vector2d>& polygon_m, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  bool inside = true;
  for (std::size_t i = 0; i < polygon_m.size(); ++i) {
    const Eigen::Vector2d& a = polygon_m[i];
    const Eigen::Vector2d edge = polygon_m[(i + 1) % polygon_m.size()] - a;
    const Eigen::Vector2d to = point - a;
    if (edge.x() * to.y() - edge.y() * to.x() < 0) inside = false;
    const double part = std::clamp(to.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (to - part * edge).norm());
  }
  return inside ? 0 : nearest;
}

/// Cells that share area with a box are lethal, others free.
inline navigate::CostGrid rasterized(const Building& building, double resolution_m) {
  using navigate::Cell;
  navigate::CostGrid grid = navigate::make_cost_grid(
      static_cast<int>(std::ceil(building.size_m.x() / resolution_m)),
      static_cast<int>(std::ceil(building.size_m.y() / resolution_m)), resolution_m, {0, 0}, 0);
  const double half = resolution_m / 2;
  for (const FloorBox& box : building.boxes) {
    const double reach = box.half_m.norm() + resolution_m;
    const Eigen::Vector2d middle(box.world_T_box.x, box.world_T_box.y);
    const Cell low = grid.cell_around(middle - Eigen::Vector2d(reach, reach));
    const Cell high = grid.cell_around(middle + Eigen::Vector2d(reach, reach));
    for (int row = std::max(0, low.row); row <= std::min(grid.height - 1, high.row); ++row)
      for (int column = std::max(0, low.column); column <= std::min(grid.width - 1, high.column); ++column) {
        const Eigen::Vector2d at = grid.middle_of({column, row});
        const std::vector<Eigen::Vector2d> square{
            at + Eigen::Vector2d(-half, -half), at + Eigen::Vector2d(half, -half),
            at + Eigen::Vector2d(half, half), at + Eigen::Vector2d(-half, half)};
        if (overlaps(box, square)) grid.at({column, row}) = navigate::kLethalCost;
      }
  }
  return grid;
}

/// The same as a map of cells of 5 cm.
inline OccupancyGrid occupancy_of(const Building& building) {
  const navigate::CostGrid costs = rasterized(building, 0.05);
  OccupancyGrid map;
  map.width = static_cast<std::size_t>(costs.width);
  map.height = static_cast<std::size_t>(costs.height);
  map.cells.reserve(costs.cells.size());
  for (const navigate::Cost cost : costs.cells)
    map.cells.push_back(cost == navigate::kLethalCost ? OccupancyGrid::kOccupied : OccupancyGrid::kFree);
  return map;
}

/// What a scanner at the base's origin sees of a building and of what stands in it: 720 rays, noise of 1 cm.
inline LaserScan scan_of(const Building& building, const std::vector<FloorDisc>& discs, const Pose2& pose,
                         Rng& rng) {
  LaserScan scan;
  scan.angle_min = -kPi;
  scan.angle_increment = kTwoPi / 720;
  scan.range_min = 0.1;
  scan.range_max = 12;
  scan.ranges.reserve(720);
  for (int ray = 0; ray < 720; ++ray) {
    const double angle = pose.yaw + scan.angle_min + ray * scan.angle_increment;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double range = INFINITY;
    for (const FloorBox& box : building.boxes)
      range = std::min(range, ray_range(box, {pose.x, pose.y}, direction));
    for (const FloorDisc& disc : discs) range = std::min(range, ray_range(disc, {pose.x, pose.y}, direction));
    scan.ranges.push_back(static_cast<float>(range + rng.normal(0, 0.01)));
  }
  return scan;
}

/// Walls around rooms that are split again and again, a door in each wall, and furniture.
class BuildingGenerator {
 public:
  explicit BuildingGenerator(std::uint64_t seed) : rng_(seed) {}

  [[nodiscard]] Building make() {
    building_ = {};
    doors_.clear();
    const double width = rng_.uniform(11, 18);
    const double height = rng_.uniform(9, 14);
    building_.size_m = {width, height};
    building_.add(0, 0, width, kWall_m);
    building_.add(0, height - kWall_m, width, height);
    building_.add(0, 0, kWall_m, height);
    building_.add(width - kWall_m, 0, width, height);
    split({0, 0}, {width, height}, 0);
    furnish();
    return building_;
  }

 private:
  static constexpr double kWall_m = 0.12;

  void split(const Eigen::Vector2d& low, const Eigen::Vector2d& high, int depth) {
    const Eigen::Vector2d size = high - low;
    const Eigen::Index axis = size.x() > size.y() ? 0 : 1;
    if (size[axis] < 5.5 || size[1 - axis] < 2.6 || depth > 4) return;
    for (int attempt = 0; attempt < 20; ++attempt) {
      const double at = rng_.uniform(low[axis] + 2.4, high[axis] - 2.4);
      if (!free_of_doors(axis, at, low, high)) continue;
      wall(axis, at, low[1 - axis], high[1 - axis]);
      Eigen::Vector2d middle_high = high;
      Eigen::Vector2d middle_low = low;
      middle_high[axis] = at;
      middle_low[axis] = at;
      split(low, middle_high, depth + 1);
      split(middle_low, high, depth + 1);
      return;
    }
  }

  /// A wall must not end in a door of another one.
  [[nodiscard]] bool free_of_doors(Eigen::Index axis, double at, const Eigen::Vector2d& low,
                                   const Eigen::Vector2d& high) const {
    return std::all_of(doors_.begin(), doors_.end(), [&](const Eigen::Vector2d& door) {
      const bool along = door[1 - axis] > low[1 - axis] - 1 && door[1 - axis] < high[1 - axis] + 1;
      return !along || std::abs(door[axis] - at) > 1.3;
    });
  }

  void wall(Eigen::Index axis, double at, double from, double to) {
    const double width = rng_.uniform(0.9, 1.1);
    const double middle = rng_.uniform(from + 1.1, to - 1.1);
    Eigen::Vector2d door;
    door[axis] = at;
    door[1 - axis] = middle;
    doors_.push_back(door);
    add_wall(axis, at, from, middle - width / 2);
    add_wall(axis, at, middle + width / 2, to);
  }

  void add_wall(Eigen::Index axis, double at, double from, double to) {
    const double half = kWall_m / 2;
    if (axis == 0)
      building_.add(at - half, from, at + half, to);
    else
      building_.add(from, at - half, to, at + half);
  }

  void furnish() {
    const int count = rng_.integer(6, 16);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at(rng_.uniform(0.5, building_.size_m.x() - 0.5),
                               rng_.uniform(0.5, building_.size_m.y() - 0.5));
      const Eigen::Vector2d half(rng_.uniform(0.1, 0.6), rng_.uniform(0.1, 0.45));
      const double yaw = rng_.chance(0.5) ? 0 : rng_.uniform(-kPi, kPi);
      const bool clear = std::all_of(doors_.begin(), doors_.end(), [&](const Eigen::Vector2d& door) {
        return (door - at).norm() > 1.3 + half.norm();
      });
      if (clear) building_.boxes.push_back({{at.x(), at.y(), yaw}, half});
    }
  }

  Rng rng_;
  Building building_;
  std::vector<Eigen::Vector2d> doors_;
};

}  // namespace extperfc
