#include "scan/azimuth_times.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::scan {

namespace {

constexpr float kTurn = 6.2831853F;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// The angle in [-pi, pi].
float wrapped(float angle) {
  return angle - kTurn * std::round(angle / kTurn);
}

/// Adds up how far the sensor has turned, clockwise, from point to point.
class Turn {
 public:
  /// The angle since the first point of all [rad]; NaN for a point without a direction.
  float at(float x, float y) {
    const float azimuth = std::atan2(y, x);
    if (!std::isfinite(azimuth) || (x == 0 && y == 0)) return kNan;
    if (std::isnan(first_)) first_ = azimuth;
    turned_ = std::isnan(before_) ? wrapped(first_ - azimuth) : turned_ + wrapped(before_ - azimuth);
    before_ = azimuth;
    return turned_;
  }
  void begin_row() { before_ = kNan; }

 private:
  float first_{kNan};
  float before_{kNan};
  float turned_{0};
};

}  // namespace

void times_from_azimuth(CloudPoints& points, std::size_t row_points, const ReadOptions& options) {
  constexpr float kMostTurns = 1.1F;  // drivers cut revolutions a little late
  points.time_s.resize(points.size());
  Turn turn;
  float least = 0;
  float most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (row_points > 0 && i % row_points == 0) turn.begin_row();
    const float turned = turn.at(points.sensor_x[i], points.sensor_y[i]);
    points.time_s[i] = turned;
    least = std::fmin(least, turned);
    most = std::fmax(most, turned);
  }
  if (most - least > kMostTurns * kTurn) return points.time_s.clear();
  const float origin = options.azimuth_times == AzimuthTimes::kStampAtEnd ? most : least;
  const float seconds_per_rad = static_cast<float>(options.turn_s) / kTurn;
  for (float& time : points.time_s) time = (time - origin) * seconds_per_rad;
}

}  // namespace extperfc::scan
