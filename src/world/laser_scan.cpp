#include "extperfc/world/laser_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "extperfc/base/math.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {

namespace {

constexpr std::size_t kMaxRays = 100000;
constexpr double kWidestSweepRad = 3 * kPi;  // drivers overlap a revolution by some rays

tl::unexpected<Error> wrong(const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, "laser scan: " + what);
}

}  // namespace

bool is_return(const LaserScan& scan, float range_m) {
  return range_m > 0 && range_m >= static_cast<float>(scan.range_min) &&
         range_m <= static_cast<float>(scan.range_max);
}

std::size_t count_returns(const LaserScan& scan) {
  return static_cast<std::size_t>(std::count_if(scan.ranges.begin(), scan.ranges.end(),
                                                [&](float range_m) { return is_return(scan, range_m); }));
}

LaserScan without_discs(LaserScan scan, const std::vector<Disc>& discs, const Pose2& frame_T_sensor) {
  if (discs.empty()) return scan;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const float range_m = scan.ranges[i];
    if (!is_return(scan, range_m)) continue;
    const double angle = frame_T_sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Eigen::Vector2d end_m(frame_T_sensor.x + range_m * std::cos(angle),
                                frame_T_sensor.y + range_m * std::sin(angle));
    const bool on_disc = std::any_of(discs.begin(), discs.end(), [&end_m](const Disc& disc) {
      return (end_m - disc.middle_m).squaredNorm() <= square(disc.radius_m);
    });
    if (on_disc) scan.ranges[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return scan;
}

Result<void> validate(const LaserScan& scan) {
  if (!std::isfinite(scan.stamp_s)) return wrong("its stamp is not a finite time");
  if (!std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment))
    return wrong("angle_min or angle_increment is not a finite number");
  if (scan.angle_increment == 0.0)
    return wrong("angle_increment is 0; the driver must say how far rays are apart");
  if (!std::isfinite(scan.range_min) || !std::isfinite(scan.range_max) || scan.range_max <= scan.range_min ||
      scan.range_max <= 0)
    return wrong("range_max " + std::to_string(scan.range_max) + " is not above range_min " +
                 std::to_string(scan.range_min));
  if (scan.ranges.empty()) return wrong("it has no rays");
  if (scan.ranges.size() > kMaxRays)
    return wrong("it has " + std::to_string(scan.ranges.size()) + " rays, more than " +
                 std::to_string(kMaxRays));
  if (std::abs(scan.angle_increment) * static_cast<double>(scan.ranges.size() - 1) > kWidestSweepRad)
    return wrong("it sweeps more than one and a half revolutions; is angle_increment in radians?");
  if (!scan.heights_m.empty() && scan.heights_m.size() != scan.ranges.size())
    return wrong("it has " + std::to_string(scan.heights_m.size()) + " heights for " +
                 std::to_string(scan.ranges.size()) + " rays");
  if (!is_finite(scan.base_T_sensor)) return wrong("the pose of the scanner on the robot is not finite");
  return {};
}

}  // namespace extperfc
