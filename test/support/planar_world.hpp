#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {

/// A floor plan of straight walls [m] for tests of scanners and of what uses them.
class PlanarWorld {
 public:
  void add_wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { walls_.push_back({a, b - a}); }
  void add_box(double left, double bottom, double right, double top) {
    add_wall({left, bottom}, {right, bottom});
    add_wall({right, bottom}, {right, top});
    add_wall({right, top}, {left, top});
    add_wall({left, top}, {left, bottom});
  }

  /// Distance to the nearest wall [m]; infinity when there is none.
  [[nodiscard]] double range(const Eigen::Vector2d& from, double angle_rad) const {
    const Eigen::Vector2d d(std::cos(angle_rad), std::sin(angle_rad));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls_) {
      const double across = d.x() * wall.direction.y() - d.y() * wall.direction.x();
      if (std::abs(across) < 1e-12) continue;
      const Eigen::Vector2d to = wall.start - from;
      const double t = (to.x() * wall.direction.y() - to.y() * wall.direction.x()) / across;
      const double u = (to.x() * d.y() - to.y() * d.x()) / across;
      if (t > 1e-9 && t < nearest && u >= 0 && u <= 1) nearest = t;
    }
    return nearest;
  }

 private:
  struct Wall {
    Eigen::Vector2d start;
    Eigen::Vector2d direction;
  };
  std::vector<Wall> walls_;
};

/// A planar lidar. What is out of its range comes as infinity.
struct PlanarScanner {
  std::size_t rays{360};
  double angle_min{-M_PI};                 ///< [rad]
  double angle_increment{2 * M_PI / 360};  ///< [rad]
  double range_min{0.05};                  ///< [m]
  double range_max{12.0};                  ///< [m]
  double sigma_m{0.01};                    ///< of a range
  Pose2 base_T_sensor;

  [[nodiscard]] LaserScan scan(const PlanarWorld& world, const Pose2& world_T_base, Rng& rng,
                               double stamp_s = 0) const {
    LaserScan scan;
    scan.stamp_s = stamp_s;
    scan.angle_min = angle_min;
    scan.angle_increment = angle_increment;
    scan.range_min = range_min;
    scan.range_max = range_max;
    scan.base_T_sensor = base_T_sensor;
    const Pose2 at = compose(world_T_base, base_T_sensor);
    for (std::size_t i = 0; i < rays; ++i) {
      const double angle = at.yaw + angle_min + static_cast<double>(i) * angle_increment;
      const double range = world.range({at.x, at.y}, angle) + (sigma_m > 0 ? rng.normal(0, sigma_m) : 0.0);
      scan.ranges.push_back(range <= range_max ? static_cast<float>(range)
                                               : std::numeric_limits<float>::infinity());
    }
    return scan;
  }
};

/// Odometry as wheels give it: off by a constant fraction and by noise that grows with the distance and the
/// rotation.
struct PlanarOdometry {
  double scale{0.02};              ///< too long by this fraction
  double veer_rad_per_m{0.01};     ///< always to the same side
  double sigma_m_per_m{0.05};      ///< of each step
  double sigma_rad_per_m{0.02};    ///< of each step
  double sigma_rad_per_rad{0.05};  ///< of each step
  Pose2 pose;                      ///< what the wheels say so far

  /// The robot moved by `step` in its own frame.
  const Pose2& move(const Pose2& step, Rng& rng) {
    const double distance_m = std::hypot(step.x, step.y);
    const double stretch = 1 + scale + rng.normal(0, sigma_m_per_m);
    const double yaw =
        veer_rad_per_m * distance_m +
        rng.normal(0, 1) * (sigma_rad_per_m * distance_m + sigma_rad_per_rad * std::abs(step.yaw));
    pose = compose(pose, {step.x * stretch, step.y * stretch, step.yaw + yaw});
    return pose;
  }
};

/// Poses of a robot that drives straight from corner to corner and turns on the spot there.
inline std::vector<Pose2> planar_drive(const std::vector<Eigen::Vector2d>& corners, double step_m,
                                       double step_rad) {
  std::vector<Pose2> poses;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d segment = corners[i] - corners[i - 1];
    const double yaw = std::atan2(segment.y(), segment.x());
    if (poses.empty()) poses.push_back({corners[0].x(), corners[0].y(), yaw});
    const Pose2 corner = poses.back();
    const double yaw_step = wrap_angle(yaw - corner.yaw);
    const int yaw_steps = static_cast<int>(std::ceil(std::abs(yaw_step) / step_rad - 1e-9));
    for (int k = 1; k <= yaw_steps; ++k)
      poses.push_back({corner.x, corner.y, wrap_angle(corner.yaw + yaw_step * k / yaw_steps)});
    const int steps = std::max(1, static_cast<int>(std::ceil(segment.norm() / step_m - 1e-9)));
    for (int k = 1; k <= steps; ++k) {
      const Eigen::Vector2d at = corners[i - 1] + segment * k / steps;
      poses.push_back({at.x(), at.y(), yaw});
    }
  }
  return poses;
}

/// A room of 8 m x 6 m about the origin with furniture that makes every direction of it different.
inline PlanarWorld planar_room() {
  PlanarWorld world;
  world.add_box(-4, -3, 4, 3);
  world.add_box(-4, 1.8, -2.6, 3);
  world.add_box(2.9, -3, 4, -2.2);
  world.add_box(1.2, 2.2, 2.2, 3);
  world.add_wall({-1.5, -3}, {-1.0, -2.2});
  world.add_wall({-1.0, -2.2}, {-0.4, -3});
  return world;
}

/// Two walls 2 m apart along x, 60 m long: places along it look alike.
inline PlanarWorld planar_corridor() {
  PlanarWorld world;
  world.add_wall({-30, -1}, {30, -1});
  world.add_wall({-30, 1}, {30, 1});
  return world;
}

/// A corridor 2 m wide around a block, 30 m x 20 m outside, with doorways and cupboards at uneven distances.
/// planar_loop_route() drives around it.
inline PlanarWorld planar_loop() {
  PlanarWorld world;
  world.add_box(-15, -10, 15, 10);
  world.add_box(-13, -8, 13, 8);
  const double along[] = {-10.6, -6.1, -2.9, 1.4, 4.4, 9.7};
  for (std::size_t i = 0; i < 6; ++i) {
    const double x = along[i];
    const double width = 0.5 + 0.17 * static_cast<double>(i);
    world.add_box(x, -10, x + width, -9.6 + 0.03 * static_cast<double>(i));
    world.add_box(x + 1.3, 7.0 + 1.0, x + 1.3 + 0.8 * width, 8.25);
    world.add_box(-x - 0.4, 9.7 - 0.04 * static_cast<double>(i), -x + 0.3 * width, 10);
    world.add_box(x * 0.9 + 0.6, -8.3, x * 0.9 + 0.6 + width, -8);
  }
  const double across[] = {-6.4, -2.2, 0.9, 5.5};
  for (std::size_t i = 0; i < 4; ++i) {
    const double y = across[i];
    const double width = 0.45 + 0.2 * static_cast<double>(i);
    world.add_box(-15, y, -14.65, y + width);
    world.add_box(14.6, -y - 0.7, 15, -y - 0.7 + width);
    world.add_box(13, y + 0.8, 13.2, y + 0.8 + width);
    world.add_box(-13.25, -y + 0.5, -13, -y + 0.5 + 0.7 * width);
  }
  return world;
}

/// Once around planar_loop(), and `beyond_m` (at most 20 m) of the first side again.
inline std::vector<Pose2> planar_loop_route(double step_m, double beyond_m) {
  return planar_drive({{-9, -8.95}, {14, -8.95}, {14, 9}, {-14, 9}, {-14, -8.95}, {-9 + beyond_m, -8.95}},
                      step_m, 0.15);
}

}  // namespace extperfc
