#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/scan/cloud_view.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::scan {

/// Where the sensor was at one moment of its sweep.
struct SensorPose {
  double time_s{0};      ///< since the cloud's stamp
  Pose target_T_sensor;  ///< in the target frame as it stood at the cloud's stamp
};

/// The sensor's path during a sweep, in order of time. A single pose means that it stood still, or that its
/// motion is unknown. Between two poses the position is interpolated linearly and the orientation along the
/// shortest arc; before the first and after the last one, the sensor stands still.
using SensorTrack = std::vector<SensorPose>;

/// The pose at a moment. Precondition: the track is not empty.
[[nodiscard]] Pose pose_at(const SensorTrack& track, double time_s);

/// Source of the times of points when a cloud has no field for them: a VLP-16 rotates clockwise at a
/// constant rate and sends its points in the order of their firing.
enum class AzimuthTimes {
  kNone,          ///< without a field, moments are unknown
  kStampAtEnd,    ///< the cloud's stamp is that of its last point
  kStampAtStart,  ///< ... of its first
};

[[nodiscard]] Result<AzimuthTimes> azimuth_times_from_name(const std::string& name);  ///< none, end, start
[[nodiscard]] const char* to_string(AzimuthTimes times);

/// First and last moment of a cloud's points, since its stamp [s].
struct TimeSpan {
  double first_s{0};
  double last_s{0};
};

/// From the time field, or else from the azimuth: then `revolution_s` long. Errors: neither is there; times
/// that are no numbers or lie more than a second from the stamp (a field in another unit, or another clock).
/// Precondition: validate(cloud) passed. O(points).
[[nodiscard]] Result<TimeSpan> time_span(const CloudView& cloud, AzimuthTimes azimuth_times,
                                         double revolution_s);

}  // namespace extperfc::scan
