#include "scan/azimuth_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "extperfc/base/math.hpp"

namespace extperfc::scan {

namespace {
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// The angle in [-pi, pi].
float wrapped(float angle) {
  return angle - kTwoPiF * std::round(angle / kTwoPiF);
}

/// Sums the clockwise rotation of the sensor from point to point.
class AzimuthSum {
 public:
  /// The angle since the first point of all [rad]; NaN for a point without a direction.
  float at(float x, float y) {
    const float azimuth = std::atan2(y, x);
    if (!std::isfinite(azimuth) || (x == 0 && y == 0)) return kNan;
    if (std::isnan(first_)) first_ = azimuth;
    rotated_ = std::isnan(before_) ? wrapped(first_ - azimuth) : rotated_ + wrapped(before_ - azimuth);
    before_ = azimuth;
    return rotated_;
  }
  void begin_row() { before_ = kNan; }

 private:
  float first_{kNan};
  float before_{kNan};
  float rotated_{0};
};

}  // namespace

void times_from_azimuth(CloudPoints& points, std::size_t row_points, const ReadOptions& options) {
  constexpr float kMaxRevolutions = 1.1F;  // drivers cut revolutions a little late
  points.time_s.resize(points.size());
  AzimuthSum sum;
  float min_angle = 0;
  float max_angle = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (row_points > 0 && i % row_points == 0) sum.begin_row();
    const float rotated = sum.at(points.sensor_x[i], points.sensor_y[i]);
    points.time_s[i] = rotated;
    min_angle = std::fmin(min_angle, rotated);
    max_angle = std::fmax(max_angle, rotated);
  }
  if (max_angle - min_angle > kMaxRevolutions * kTwoPiF) return points.time_s.clear();
  const float origin = options.azimuth_times == AzimuthTimes::kStampAtEnd ? max_angle : min_angle;
  const float seconds_per_rad = static_cast<float>(options.revolution_s) / kTwoPiF;
  for (float& time : points.time_s) time = (time - origin) * seconds_per_rad;
}

}  // namespace extperfc::scan
