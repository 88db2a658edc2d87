#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/arm/joint_trajectory.hpp"

namespace extperfc::arm {

namespace {

constexpr double kMinIntervalS = 2e-5;  // nearer borders are merged: rounding would drown accelerations
constexpr double kOvershoot = 2e-3;     // of limits, that stretching has to take away
constexpr int kMaxMerged = 64;
constexpr int kStretches = 8;
constexpr int kLooks = 12;             // parts of an interval, at whose ends the distance is looked at
constexpr double kBetweenLooks = 0.9;  // of the tolerance; between them it may be a little more

/// Bezier points of the interpolation between two points, one column each; three at least.
using Bezier = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, 6>;

Bezier interpolate(const TrajectoryPoint& a, const TrajectoryPoint& b) {
  const double h = b.time_s - a.time_s;
  if (!a.acceleration || !b.acceleration) {
    Bezier points(a.position.size(), 4);
    points << a.position, a.position + h / 3 * a.velocity, b.position - h / 3 * b.velocity, b.position;
    return points;
  }
  Bezier points(a.position.size(), 6);
  points << a.position, a.position + h / 5 * a.velocity,
      a.position + 2 * h / 5 * a.velocity + h * h / 20 * *a.acceleration,
      b.position - 2 * h / 5 * b.velocity + h * h / 20 * *b.acceleration, b.position - h / 5 * b.velocity,
      b.position;
  return points;
}

/// Bezier points of the derivative by a time of which the interval lasts `h`.
Bezier derive(const Bezier& points, double h) {
  const auto n = points.cols() - 1;
  return static_cast<double>(n) / h * (points.rightCols(n) - points.leftCols(n));
}

JointVector value(Bezier points, double y) {
  for (Eigen::Index n = points.cols() - 1; n > 0; --n)
    for (Eigen::Index k = 0; k < n; ++k) points.col(k) += y * (points.col(k + 1) - points.col(k)).eval();
  return points.col(0);
}

double use(const Bezier& points, const JointVector& limit) {
  return (points.cwiseAbs().rowwise().maxCoeff().array() / limit.array()).maxCoeff();
}

/// By how much time has to be stretched for the interpolation between two points to keep the limits.
double needed_stretch(const TrajectoryPoint& a, const TrajectoryPoint& b, const TrajectoryLimits& limits) {
  const double h = b.time_s - a.time_s;
  const auto velocity = derive(interpolate(a, b), h);
  return std::max(use(velocity, limits.velocity), std::sqrt(use(derive(velocity, h), limits.acceleration)));
}

class PointMaker {
 public:
  PointMaker(const JointTrajectory& trajectory, const PointParams& params)
      : trajectory_(trajectory), params_(params) {}

  std::vector<TrajectoryPoint> make() {
    const auto times = params_.even_interval_s > 0 ? even_times() : needed_times();
    double stretch = 1;
    auto points = at(times, stretch);
    for (int i = 0; i < kStretches; ++i) {
      double more = 1;
      for (std::size_t k = 1; k < points.size(); ++k)
        more = std::max(more, needed_stretch(points[k - 1], points[k], trajectory_.limits()));
      if (more <= 1 + 1e-10) break;
      stretch *= more * (1 + 1e-10);
      points = at(times, stretch);
    }
    return points;
  }

 private:
  /// The trajectory's state at `time_s`, slowed down by `stretch`.
  [[nodiscard]] TrajectoryPoint point(double time_s, double stretch) const {
    const double rounded_s = std::round(time_s * stretch * 1e9) / 1e9;
    const bool last = time_s >= trajectory_.duration_s();
    const auto state = trajectory_.sample(last ? time_s : rounded_s / stretch);
    TrajectoryPoint result{rounded_s, state.position, state.velocity / stretch, std::nullopt};
    if (params_.interpolation == Interpolation::kQuintic)
      result.acceleration = state.acceleration / (stretch * stretch);
    return result;
  }

  [[nodiscard]] std::vector<TrajectoryPoint> at(const std::vector<double>& times_s, double stretch) const {
    std::vector<TrajectoryPoint> points;
    points.reserve(times_s.size());
    for (const double time_s : times_s) points.push_back(point(time_s, stretch));
    return points;
  }

  [[nodiscard]] std::vector<double> even_times() const {
    const auto count = static_cast<std::size_t>(
        std::max(1.0, std::ceil(trajectory_.duration_s() / params_.even_interval_s - 1e-9)));
    std::vector<double> times;
    for (std::size_t i = 0; i <= count; ++i)
      times.push_back(trajectory_.duration_s() * static_cast<double>(i) / static_cast<double>(count));
    return times;
  }

  /// Borders that are not too near each other; the first and the last stay.
  [[nodiscard]] std::vector<double> candidates() const {
    const auto borders = trajectory_.borders_s();
    std::vector<double> kept{0.0};
    for (const double border : borders)
      if (border > kept.back() + kMinIntervalS) kept.push_back(border);
    if (kept.size() > 1) kept.pop_back();
    kept.push_back(trajectory_.duration_s());
    return kept;
  }

  /// Is interpolation between two instants good enough?
  [[nodiscard]] bool good(double from_s, double to_s) const {
    if (to_s - from_s > params_.max_interval_s) return false;
    const auto a = point(from_s, 1);
    const auto b = point(to_s, 1);
    if (needed_stretch(a, b, trajectory_.limits()) > 1 + kOvershoot / 2) return false;
    const auto curve = interpolate(a, b);
    for (int i = 1; i < kLooks; ++i) {
      const double y = static_cast<double>(i) / kLooks;
      const double time_s = a.time_s + y * (b.time_s - a.time_s);
      const JointVector off = value(curve, y) - trajectory_.sample(time_s).position;
      if (off.cwiseAbs().maxCoeff() > kBetweenLooks * params_.tolerance_rad) return false;
    }
    return true;
  }

  /// Halves an interval until interpolation is good; adds the ends of the parts.
  void divide(double from_s, double to_s, std::vector<double>& times) const {
    if (to_s - from_s < 2 * kMinIntervalS || good(from_s, to_s)) {
      times.push_back(to_s);
      return;
    }
    const double middle_s = (from_s + to_s) / 2;
    divide(from_s, middle_s, times);
    divide(middle_s, to_s, times);
  }

  [[nodiscard]] std::vector<double> needed_times() const {
    const auto borders = candidates();
    std::vector<double> times{borders.front()};
    for (std::size_t i = 0; i + 1 < borders.size();) {
      std::size_t next = i + 1;
      for (std::size_t step = 2; step <= kMaxMerged && i + step < borders.size(); step *= 2) {
        if (!good(borders[i], borders[i + step])) break;
        next = i + step;
      }
      divide(borders[i], borders[next], times);
      i = next;
    }
    return times;
  }

  const JointTrajectory& trajectory_;
  const PointParams& params_;
};

Result<void> check(const JointTrajectory& trajectory, const PointParams& params) {
  const auto invalid = [](const char* why) {
    return fail(ErrorCode::kInvalidArgument, std::string("points of a trajectory: ") + why);
  };
  if (!(params.even_interval_s >= 0) || (params.even_interval_s > 0 && params.even_interval_s < 1e-4))
    return invalid("even_interval_s must be 0 or at least 1e-4");
  if (!(params.max_interval_s >= 1e-3)) return invalid("max_interval_s must be at least 1e-3");
  if (!(params.tolerance_rad > 0)) return invalid("tolerance_rad must be positive");
  if (params.interpolation == Interpolation::kQuintic && !trajectory.limits().jerk)
    return invalid("its accelerations jump: use cubic interpolation or set jerk limits");
  return {};
}

}  // namespace

Result<std::vector<TrajectoryPoint>> to_points(const JointTrajectory& trajectory, const PointParams& params) {
  if (auto checked = check(trajectory, params); !checked) return tl::unexpected(checked.error());
  if (trajectory.duration_s() > 0) return PointMaker(trajectory, params).make();
  const auto state = trajectory.sample(0);
  TrajectoryPoint only{0, state.position, state.velocity, std::nullopt};
  if (params.interpolation == Interpolation::kQuintic) only.acceleration = state.acceleration;
  return std::vector<TrajectoryPoint>{std::move(only)};
}

}  // namespace extperfc::arm
