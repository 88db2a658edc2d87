#include "extperfc/scan/sensor_track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "scan/field_reader.hpp"

namespace extperfc::scan {

Pose pose_at(const SensorTrack& track, double time_s) {
  const auto next = std::find_if(track.begin(), track.end(),
                                 [&](const SensorPose& pose) { return !(pose.time_s <= time_s); });
  if (next == track.begin()) return track.front().target_T_sensor;
  if (next == track.end()) return track.back().target_T_sensor;
  const SensorPose& before = *(next - 1);
  const double ratio = (time_s - before.time_s) / (next->time_s - before.time_s);
  const Eigen::Quaterniond from(before.target_T_sensor.linear());
  const Eigen::Quaterniond to(next->target_T_sensor.linear());
  Pose pose = Pose::Identity();
  pose.linear() = from.slerp(ratio, to).toRotationMatrix();
  pose.translation() =
      (1 - ratio) * before.target_T_sensor.translation() + ratio * next->target_T_sensor.translation();
  return pose;
}

Result<TimeSpan> time_span(const CloudView& cloud, AzimuthTimes azimuth_times, double revolution_s) {
  if (!cloud.time) {
    if (azimuth_times == AzimuthTimes::kStampAtEnd) return TimeSpan{-revolution_s, 0};
    if (azimuth_times == AzimuthTimes::kStampAtStart) return TimeSpan{0, revolution_s};
    return fail(ErrorCode::kNotFound,
                "the cloud has no field time, t or timestamp: let the driver add it, or set azimuth_times");
  }
  if (cloud.size() == 0) return TimeSpan{};
  const AnyField read(cloud, cloud.time->field);
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for_each_point(cloud, [&](const std::uint8_t* point) {
    const double time_s = read(point);
    first = std::min(first, time_s);  // NaN is never less
    last = std::max(last, time_s);
  });
  const TimeSpan span{first * cloud.time->unit_s - cloud.time->origin_s,
                      last * cloud.time->unit_s - cloud.time->origin_s};
  constexpr double kMaxOffset = 1.0;  // [s]
  if (!(span.first_s >= -kMaxOffset && span.last_s <= kMaxOffset))
    return fail(ErrorCode::kUnsupported, "the points' times reach from " + std::to_string(span.first_s) +
                                             " to " + std::to_string(span.last_s) +
                                             " s about the cloud's stamp: another unit, or another clock?");
  return span;
}

}  // namespace extperfc::scan
