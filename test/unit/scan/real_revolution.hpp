#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "extperfc/scan/cloud_view.hpp"

namespace extperfc::scan {

/// A point as velodyne_pointcloud lays it out, padded to 24 bytes.
struct VelodynePoint {
  float x, y, z;       ///< sensor frame [m]; NaN for a beam without a return
  float intensity;     ///< [0, 255]
  std::uint16_t ring;  ///< 0 the lowest
  std::uint16_t padding;
  float time;  ///< since the stamp, which is the end of the revolution [s]
};

/// A revolution of a real VLP-16, with the beams that gave no return: `firings` rows of 16 rings.
struct RealRevolution {
  std::vector<VelodynePoint> points;
  std::size_t firings{0};

  /// Every beam: an organised cloud.
  [[nodiscard]] CloudView organised() const;
};

/// Only the beams with a return, as most drivers send them.
[[nodiscard]] std::vector<VelodynePoint> returns_of(const RealRevolution& revolution);
[[nodiscard]] CloudView view_of(const std::vector<VelodynePoint>& points);

/// The revolution of MRPT's recording test_velodyne_VLP16.rawlog: a car park, seen from a car's roof, 2.1 m
/// above the ground. Without points when MRPT or its recording (package mrpt-common) is missing; `why` says
/// which. Throws when the recording is there but cannot be read.
[[nodiscard]] RealRevolution read_real_revolution(std::string& why);

}  // namespace extperfc::scan
