#pragma once

#include <optional>

#include "extperfc/scan/ground.hpp"

#include "scan/cloud_points.hpp"

namespace extperfc::scan {

/// The plane that most points of the height band lie on: MSAC (Torr and Zisserman 2000, a RANSAC that scores
/// inliers by their distance), then least squares over the inliers.
/// No value when there are too few points or the plane is too steep. At most 2000 points are looked at,
/// evenly taken from the cloud: bounded time. Deterministic for one seed.
[[nodiscard]] std::optional<Ground> find_ground(const CloudPoints& points, const GroundParams& params);

}  // namespace extperfc::scan
