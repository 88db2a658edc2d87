#include "extperfc/arm/timed_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "arm/motion/spline_proof.hpp"

namespace extperfc::arm {

namespace {

Result<void> check(const std::vector<std::string>& joints, const std::vector<TrajectoryPoint>& points) {
  const auto count = static_cast<Eigen::Index>(joints.size());
  if (joints.empty() || joints.size() > static_cast<std::size_t>(kMaxJoints))
    return fail(ErrorCode::kInvalidArgument,
                "a trajectory needs 1 to " + std::to_string(kMaxJoints) + " joints");
  if (points.empty()) return fail(ErrorCode::kInvalidArgument, "the trajectory has no points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    const std::string which = "point " + std::to_string(i) + " of the trajectory ";
    if (point.position.size() != count || point.velocity.size() != count)
      return fail(ErrorCode::kInvalidArgument,
                  which + "needs a position and a velocity for each of its joints");
    if (!point.position.allFinite() || !point.velocity.allFinite() || !std::isfinite(point.time_s))
      return fail(ErrorCode::kInvalidArgument, which + "has a value that is not finite");
    if (point.time_s < 0.0 || (i > 0 && point.time_s <= points[i - 1].time_s))
      return fail(ErrorCode::kInvalidArgument, which + "does not come after the one before it");
  }
  return {};
}

/// Cubic Hermite spline at fraction u in [0, 1] of an interval of h seconds.
JointVector hermite(const TrajectoryPoint& a, const TrajectoryPoint& b, double h, double u) {
  const double u2 = u * u, u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * a.position + (u3 - 2 * u2 + u) * h * a.velocity +
         (3 * u2 - 2 * u3) * b.position + (u3 - u2) * h * b.velocity;
}

}  // namespace

Result<TimedPath> TimedPath::make(std::vector<std::string> joints, std::vector<TrajectoryPoint> points) {
  if (auto ok = check(joints, points); !ok) return tl::unexpected(ok.error());
  return TimedPath(std::move(joints), std::move(points));
}

JointVector TimedPath::position(double time_s) const {
  if (time_s <= points_.front().time_s) return points_.front().position;
  const auto next =
      std::upper_bound(points_.begin(), points_.end(), time_s,
                       [](double time, const TrajectoryPoint& point) { return time < point.time_s; });
  if (next == points_.end()) return points_.back().position;
  const auto& before = *(next - 1);
  const double h = next->time_s - before.time_s;
  return hermite(before, *next, h, (time_s - before.time_s) / h);
}

Result<TimedPath> TimedPath::only(const std::vector<std::string>& joints) const {
  std::vector<Eigen::Index> chosen;
  for (const auto& joint : joints) {
    const auto found = std::find(joints_.begin(), joints_.end(), joint);
    if (found == joints_.end())
      return fail(ErrorCode::kNotFound, "the trajectory does not contain joint " + joint);
    chosen.push_back(found - joints_.begin());
  }
  std::vector<TrajectoryPoint> points;
  for (const auto& point : points_) {
    const auto count = static_cast<Eigen::Index>(chosen.size());
    TrajectoryPoint part{point.time_s, JointVector(count), JointVector(count), {}};
    for (Eigen::Index i = 0; i < count; ++i) {
      part.position[i] = point.position[chosen[static_cast<std::size_t>(i)]];
      part.velocity[i] = point.velocity[chosen[static_cast<std::size_t>(i)]];
    }
    points.push_back(std::move(part));
  }
  return TimedPath(joints, std::move(points));
}

double TimedPath::deviation(const JointVector& measured, double from_s, double to_s) const {
  constexpr double kStep = 0.01;  // [s]
  double smallest = std::numeric_limits<double>::infinity();
  const double from = std::clamp(from_s, 0.0, duration_s()), to = std::clamp(to_s, from, duration_s());
  for (double t = from;; t = std::min(t + kStep, to)) {
    smallest = std::min(smallest, (position(t) - measured).cwiseAbs().maxCoeff());
    if (t >= to) return smallest;
  }
}

double TimedPath::free_until(CollisionChecker& checker, double from_s) const {
  const double begin_s = std::clamp(from_s, 0.0, duration_s());
  if (!checker.is_free(position(begin_s))) return begin_s;
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const auto& before = points_[i - 1];
    const double length_s = points_[i].time_s - before.time_s;
    if (points_[i].time_s <= begin_s) continue;
    const double begin = std::max(0.0, (begin_s - before.time_s) / length_s);
    const double proven = proven_fraction(checker, before, points_[i], begin);
    if (proven < 1) return before.time_s + proven * length_s;
  }
  return duration_s();
}

}  // namespace extperfc::arm
