#pragma once

#include <vector>

#include <Eigen/Core>

#include "scan/cloud_points.hpp"

namespace extperfc::scan {

/// A beam that gave no return.
struct SilentBeam {
  Eigen::Vector3f direction{1, 0, 0};  ///< in the sensor's frame, unit length
  float time_s{0};                     ///< since the stamp
};

/// The beams of an organised cloud that gave no return (NaN or all zero), by their place in it: the shorter
/// side of the cloud is its rings, each with one elevation; the longer side its firings, each with one
/// azimuth. Both come from the beams that gave a return. Precondition: `points` is the whole cloud.
void silent_beams(const CloudView& cloud, const CloudPoints& points, std::vector<SilentBeam>& beams);

}  // namespace extperfc::scan
