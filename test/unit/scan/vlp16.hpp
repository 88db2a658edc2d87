#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/pose.hpp"

#include "test/unit/scan/cloud_builder.hpp"

namespace extperfc::scan {

/// Distance from a point along a unit direction to what is there [m]; infinity for nothing.
using Scene = std::function<double(const Eigen::Vector3d& from, const Eigen::Vector3d& direction)>;

constexpr double kNothingThere = std::numeric_limits<double>::infinity();

/// The plane normal . p = offset.
inline Scene plane(const Eigen::Vector3d& normal, double offset) {
  return [=](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
    const double distance = (offset - normal.dot(from)) / normal.dot(direction);
    return distance > 1e-9 ? distance : kNothingThere;
  };
}

/// A box with faces along the axes.
inline Scene box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return [=](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
    double in = 0;
    double out = kNothingThere;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (low[axis] - from[axis]) / direction[axis];
      const double b = (high[axis] - from[axis]) / direction[axis];
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    return in <= out && in > 1e-9 ? in : kNothingThere;
  };
}

inline Scene all_of(std::vector<Scene> parts) {
  return [parts = std::move(parts)](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
    double nearest = kNothingThere;
    for (const auto& part : parts) nearest = std::min(nearest, part(from, direction));
    return nearest;
  };
}

inline Scene floor_at(double z) {
  return plane(Eigen::Vector3d::UnitZ(), z);
}

/// A revolution of a VLP-16: 16 rings of 2 degrees, 1800 firings clockwise in 0.1 s.
struct Vlp16 {
  double duration_s{0.1};
  int firings{1800};
  double stamp_s{0.1};  ///< of the cloud, since the first firing: drivers stamp the end
  double noise_m{0};
  double farthest_m{100};
  std::uint64_t seed{1};
};

/// `world_T_sensor` at a time since the first firing [s].
inline std::vector<TestPoint> revolution(const Scene& scene,
                                         const std::function<Pose(double)>& world_T_sensor,
                                         const Vlp16& lidar = {}) {
  Rng rng(lidar.seed);
  std::vector<TestPoint> points;
  for (int firing = 0; firing < lidar.firings; ++firing) {
    const double time_s = lidar.duration_s * firing / lidar.firings;
    const double azimuth = M_PI - 2 * M_PI * firing / lidar.firings;
    const Pose pose = world_T_sensor(time_s);
    for (std::uint16_t ring = 0; ring < 16; ++ring) {
      const double elevation = (-15 + 2 * ring) * M_PI / 180;
      const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = scene(pose.translation(), pose.linear() * direction);
      if (!(range < lidar.farthest_m)) continue;
      if (lidar.noise_m > 0) range += rng.normal(0, lidar.noise_m);
      const Eigen::Vector3f p = (range * direction).cast<float>();
      points.push_back({p.x(), p.y(), p.z(), 50, ring, static_cast<float>(time_s - lidar.stamp_s)});
    }
  }
  return points;
}

inline std::vector<TestPoint> revolution(const Scene& scene, const Pose& world_T_sensor,
                                         const Vlp16& lidar = {}) {
  return revolution(
      scene, [&](double) { return world_T_sensor; }, lidar);
}

/// The end of a ray in the scan's frame.
inline Eigen::Vector2d end_of(const PlanarScan& scan, std::size_t ray) {
  const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(ray);
  return static_cast<double>(scan.ranges[ray]) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

}  // namespace extperfc::scan
