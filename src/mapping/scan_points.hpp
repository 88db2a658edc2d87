#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/world/laser_scan.hpp"

namespace extperfc::mapping {

/// A point where a ray met a surface, in the base's frame.
struct SurfacePoint {
  Eigen::Vector2f position;  ///< [m]
  Eigen::Vector2f normal;    ///< of unit length, faces the scanner; zero where the neighbours form no line

  [[nodiscard]] bool has_normal() const { return normal.x() != 0.0F || normal.y() != 0.0F; }
};

/// Points of a scan, in the base's frame [m].
struct ScanPoints {
  std::vector<SurfacePoint> surface;
  std::vector<Eigen::Vector2f> clear;  ///< ends of rays without a return, free up to here
  Eigen::Vector2f scanner{0, 0};
};

struct ScanPointLimits {
  double max_usable_range_m{0};  ///< returns beyond do not count; 0: the scan's range_max
  double max_range_m{0};         ///< rays without return are free up to here; 0: they are not used
};

/// The returns of a valid scan with the direction of the surface at each, from a line through its neighbours.
/// Dense scans are thinned to one point every few centimetres of surface, and to a bounded number in all.
[[nodiscard]] ScanPoints scan_points(const LaserScan& scan, const ScanPointLimits& limits);

}  // namespace extperfc::mapping
