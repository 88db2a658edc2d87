#include "test/benchmark/map/carmen_writer.hpp"

#include <cmath>
#include <cstdio>
#include <string>

namespace extperfc::benchmark {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6f ", value);
  return text;
}

std::string numbers(const Pose2& pose) {
  return number(pose.x) + number(pose.y) + number(pose.yaw);
}

}  // namespace

void CarmenWriter::add(const LaserScan& scan, const Pose2& odom_T_base) {
  const double field_of_view = scan.angle_increment * static_cast<double>(scan.ranges.size());
  std::string line = "ROBOTLASER1 0 " + number(scan.angle_min) + number(field_of_view) +
                     number(scan.angle_increment) + number(scan.range_max) + "0.01 0 " +
                     std::to_string(scan.ranges.size()) + " ";
  for (const float range : scan.ranges)
    line += number(std::isfinite(range) ? static_cast<double>(range) : scan.range_max);
  line += "0 " + numbers(compose(odom_T_base, scan.base_T_sensor)) + numbers(odom_T_base);
  out_ << line << "0 0 0 0 0 " << number(scan.stamp_s) << "nobody " << number(scan.stamp_s) << '\n';
}

Result<void> CarmenWriter::finish() {
  out_.close();
  if (out_.fail()) return fail(ErrorCode::kFailed, "cannot write " + file_.string());
  return {};
}

}  // namespace extperfc::benchmark
