#include "ros/convert/laser_scan.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>

#include "extperfc/base/math.hpp"

namespace extperfc::ros_convert {

namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::string degrees(double angle_rad) {
  char text[32];
  (void)std::snprintf(text, sizeof text, "%.1f", angle_rad * 180.0 / kPi);
  return text;
}

/// Index of the echo that counts; kNone without echoes.
std::size_t strongest(const sensor_msgs::LaserEcho& ranges, const std::vector<float>& intensities,
                      float range_min, float range_max) {
  const bool graded = intensities.size() == ranges.echoes.size();
  std::size_t best = kNone;
  for (std::size_t i = 0; i < ranges.echoes.size(); ++i) {
    const float range = ranges.echoes[i];
    if (!(range >= range_min && range <= range_max)) continue;
    if (best == kNone || (graded && intensities[i] > intensities[best])) best = i;
  }
  if (best != kNone) return best;
  return ranges.echoes.empty() ? kNone : 0;
}

}  // namespace

Result<LaserScan> to_laser_scan(const sensor_msgs::LaserScan& message, const Pose& base_T_scanner,
                                double max_tilt_rad) {
  const Eigen::Matrix3d rotation = base_T_scanner.linear();
  const bool upside_down = rotation(2, 2) < 0;
  const double tilt_rad = std::atan2(std::hypot(rotation(0, 2), rotation(1, 2)), std::abs(rotation(2, 2)));
  if (!(tilt_rad <= max_tilt_rad))  // NaN fails too
    return fail(ErrorCode::kInvalidArgument,
                "the scanner " + message.header.frame_id + " is tilted by " + degrees(tilt_rad) +
                    " degrees against the floor, more than " + degrees(max_tilt_rad) +
                    ": a planar map needs a level scanner; is the transform to it right?");
  LaserScan scan;
  scan.stamp_s = message.header.stamp.toSec();
  const double sense = upside_down ? -1.0 : 1.0;
  scan.angle_min = sense * static_cast<double>(message.angle_min);
  scan.angle_increment = sense * static_cast<double>(message.angle_increment);
  scan.range_min = static_cast<double>(message.range_min);
  scan.range_max = static_cast<double>(message.range_max);
  scan.base_T_sensor = to_pose2(base_T_scanner);
  scan.ranges = message.ranges;
  if (auto valid = validate(scan); !valid) return tl::unexpected(valid.error());
  return scan;
}

sensor_msgs::LaserScan to_single_echo(const sensor_msgs::MultiEchoLaserScan& message) {
  sensor_msgs::LaserScan scan;
  scan.header = message.header;
  scan.angle_min = message.angle_min;
  scan.angle_max = message.angle_max;
  scan.angle_increment = message.angle_increment;
  scan.time_increment = message.time_increment;
  scan.scan_time = message.scan_time;
  scan.range_min = message.range_min;
  scan.range_max = message.range_max;
  const bool graded = message.intensities.size() == message.ranges.size();
  scan.ranges.reserve(message.ranges.size());
  if (graded) scan.intensities.reserve(message.ranges.size());
  static const std::vector<float> kUngraded;
  for (std::size_t i = 0; i < message.ranges.size(); ++i) {
    const auto& intensities = graded ? message.intensities[i].echoes : kUngraded;
    const auto best = strongest(message.ranges[i], intensities, message.range_min, message.range_max);
    scan.ranges.push_back(best == kNone ? std::numeric_limits<float>::quiet_NaN()
                                        : message.ranges[i].echoes[best]);
    if (graded) scan.intensities.push_back(best < intensities.size() ? intensities[best] : 0.0F);
  }
  return scan;
}

}  // namespace extperfc::ros_convert
