#include "arm/trajectory/stage_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::arm {

namespace {

/// How far s goes during a phase.
double length_of(const PathPhase& phase) {
  return phase.duration_s * (phase.speed + 0.5 * phase.acceleration * phase.duration_s);
}

double end_speed(const PathPhase& phase) {
  return std::max(0.0, phase.speed + phase.acceleration * phase.duration_s);
}

/// Largest Bezier point of p(y)^2 (x0 + (x1 - x0) y) for the cubic p of the points `w`.
double largest_square(const std::array<double, 4>& w, double x0, double x1) {
  const std::array<double, 7> square{w[0] * w[0],
                                     w[0] * w[1],
                                     (3 * w[1] * w[1] + 2 * w[0] * w[2]) / 5,
                                     (w[0] * w[3] + 9 * w[1] * w[2]) / 10,
                                     (3 * w[2] * w[2] + 2 * w[1] * w[3]) / 5,
                                     w[2] * w[3],
                                     w[3] * w[3]};
  double largest = square[0] * x0;
  for (int k = 1; k < 7; ++k)
    largest = std::max(largest, ((7 - k) * square[k] * x0 + k * square[k - 1] * x1) / 7);
  return std::max(largest, square[6] * x1);
}

}  // namespace

StageShape stage_shape(const PathPiece& piece, double offset, double length) {
  const double a = offset / piece.length;
  const double b = (offset + length) / piece.length;
  StageShape shape;
  for (int k = 0; k < 4; ++k) {  // polar forms of the cubics at three of a and b
    const double x = k > 2 ? b : a;
    const double y = k > 1 ? b : a;
    const double z = k > 0 ? b : a;
    const double sum = x + y + z;
    const double pairs = x * y + y * z + z * x;
    const double all = x * y * z;
    shape.step[k] = pairs - 2 * all;
    shape.along[k] = shape.step[k] + 12 * ((1 + a) * pairs / 3 - all - a * sum / 3);
    shape.across[k] = 2 * (sum - pairs) / piece.length;
  }
  return shape;
}

JointInterval acceleration_range(const PathPiece& piece, const PathPhase& phase) {
  const JointVector first = phase.acceleration * piece.direction;
  JointInterval range{first, first};
  if (piece.straight) return range;
  const auto shape = stage_shape(piece, phase.offset, length_of(phase));
  const double x = phase.speed * phase.speed;
  for (int k = 0; k < 4; ++k) {
    const JointVector value =
        first + (phase.acceleration * shape.along[k] + x * shape.across[k]) * piece.direction_change;
    range.lower = k == 0 ? value : range.lower.cwiseMin(value).eval();
    range.upper = k == 0 ? value : range.upper.cwiseMax(value).eval();
  }
  return range;
}

double velocity_use(const PathPiece& piece, const PathPhase& phase, const JointVector& limit) {
  const double fastest = std::max(phase.speed, end_speed(phase));
  if (piece.straight) return fastest * (piece.direction.array() / limit.array()).abs().maxCoeff();
  const auto shape = stage_shape(piece, phase.offset, length_of(phase));
  const double x0 = phase.speed * phase.speed;
  const double x1 = end_speed(phase) * end_speed(phase);
  // step(y) rises from end to end, so that each |q'_j| is largest at an end: mostly that is enough to know.
  const JointVector first = piece.direction + shape.step[0] * piece.direction_change;
  const JointVector last = piece.direction + shape.step[3] * piece.direction_change;
  const double rough =
      fastest * (first.cwiseAbs().cwiseMax(last.cwiseAbs()).array() / limit.array()).maxCoeff();
  if (rough <= 1) return rough;
  double largest = 0;
  for (Eigen::Index j = 0; j < limit.size(); ++j) {
    std::array<double, 4> tangent{};
    for (int k = 0; k < 4; ++k)
      tangent[k] = (piece.direction[j] + piece.direction_change[j] * shape.step[k]) / limit[j];
    largest = std::max(largest, largest_square(tangent, x0, x1));
  }
  return std::sqrt(largest);
}

double acceleration_use(const PathPiece& piece, const PathPhase& phase, const JointVector& limit) {
  const auto range = acceleration_range(piece, phase);
  return (range.lower.cwiseAbs().cwiseMax(range.upper.cwiseAbs()).array() / limit.array()).maxCoeff();
}

}  // namespace extperfc::arm
