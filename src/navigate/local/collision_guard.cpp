#include "extperfc/navigate/collision_guard.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kStraight_rad_s = 1e-6;  // slower rotations count as straight motion
constexpr double kStopFactor = 0.05;      // commands slowed to less than this part are stops
constexpr float kSmoothed_m = 1.2F;       // nearer ranges are smoothed
constexpr float kSameSurface_m = 0.1F;    // returns with a larger difference are of another surface
constexpr std::size_t kBeside = 2;        // rays on either side
constexpr double kClosing_m_s = 1e-3;     // slower motion towards a point inside the margin is ignored

/// Signed distances of a point from the lines of a counter-clockwise polygon's edges: above 0 outside.
struct Depth {
  double outside_m{-kNever};
  Eigen::Vector2d normal{0, 0};  ///< outwards, of the edge with the largest one
};

Depth depth_of(const std::vector<Eigen::Vector2d>& corners_m, const Eigen::Vector2d& point_m) {
  Depth depth;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const Eigen::Vector2d edge = corners_m[(i + 1) % corners_m.size()] - corners_m[i];
    const Eigen::Vector2d normal = Eigen::Vector2d(edge.y(), -edge.x()).normalized();
    const double outside_m = normal.dot(point_m - corners_m[i]);
    if (outside_m > depth.outside_m) depth = {outside_m, normal};
  }
  return depth;
}

/// The time at which a point that moves with `velocity` first crosses an edge [s].
double straight_time(const std::vector<Eigen::Vector2d>& corners_m, const Eigen::Vector2d& point_m,
                     const Eigen::Vector2d& velocity) {
  double first_s = kNever;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const Eigen::Vector2d& a = corners_m[i];
    const Eigen::Vector2d edge = corners_m[(i + 1) % corners_m.size()] - a;
    const double across = cross(velocity, edge);
    if (std::abs(across) < 1e-12) continue;
    const double time_s = cross(a - point_m, edge) / across;
    const double part = cross(a - point_m, velocity) / across;
    if (time_s >= 0 && part >= 0 && part <= 1) first_s = std::min(first_s, time_s);
  }
  return first_s;
}

/// The same on a circle about `centre` with the angular velocity `rate` [rad/s].
double arc_time(const std::vector<Eigen::Vector2d>& corners_m, const Eigen::Vector2d& point_m,
                const Eigen::Vector2d& centre, double rate) {
  const Eigen::Vector2d from = point_m - centre;
  const double radius2 = from.squaredNorm();
  const double start = std::atan2(from.y(), from.x());
  double first_s = kNever;
  for (std::size_t i = 0; i < corners_m.size(); ++i) {
    const Eigen::Vector2d a = corners_m[i] - centre;
    const Eigen::Vector2d edge = corners_m[(i + 1) % corners_m.size()] - corners_m[i];
    const double length2 = edge.squaredNorm();
    const double along = -a.dot(edge) / length2;
    const double rest2 = radius2 - (a + along * edge).squaredNorm();
    if (rest2 < 0) continue;
    const double half = std::sqrt(rest2 / length2);
    for (const double part : {along - half, along + half}) {
      if (part < 0 || part > 1) continue;
      const Eigen::Vector2d at = a + part * edge;
      double angle = (std::atan2(at.y(), at.x()) - start) * (rate > 0 ? 1 : -1);
      if (angle < 0) angle += kTwoPi;
      first_s = std::min(first_s, angle / std::abs(rate));
    }
  }
  return first_s;
}

/// Points within the margin are judged by the bare outline: a base passes a post beside it.
double time_of(const std::vector<Eigen::Vector2d>& bare_m, const std::vector<Eigen::Vector2d>& grown_m,
               const Eigen::Vector2d& point_m, const Twist2& twist) {
  // In the base's frame the point moves against the base.
  const Eigen::Vector2d velocity(-twist.vx + twist.wz * point_m.y(), -twist.vy - twist.wz * point_m.x());
  const Depth depth = depth_of(bare_m, point_m);
  const bool beside = depth.outside_m > 0 && depth_of(grown_m, point_m).outside_m <= 0;
  const std::vector<Eigen::Vector2d>& corners_m = beside ? bare_m : grown_m;
  if (depth.outside_m <= 0) return depth.normal.dot(velocity) < -kClosing_m_s ? 0 : kNever;
  if (std::abs(twist.wz) < kStraight_rad_s) return straight_time(corners_m, point_m, velocity);
  const Eigen::Vector2d centre(-twist.vy / twist.wz, twist.vx / twist.wz);
  return arc_time(corners_m, point_m, centre, -twist.wz);
}

/// Of the returns on the same surface as ray `index`, itself among them; the lower one of the two in the
/// middle.
double median_around(const LaserScan& scan, std::size_t index) {
  std::array<float, 2 * kBeside + 1> ranges{};
  std::size_t count = 0;
  const float own = scan.ranges[index];
  const std::size_t first = index - std::min(index, kBeside);
  const std::size_t end = std::min(scan.ranges.size(), index + kBeside + 1);
  for (std::size_t i = first; i < end; ++i) {
    const float range = scan.ranges[i];
    if (is_return(scan, range) && std::abs(range - own) < kSameSurface_m) ranges.at(count++) = range;
  }
  const auto middle = static_cast<std::ptrdiff_t>((count - 1) / 2);
  std::nth_element(ranges.begin(), ranges.begin() + middle,
                   ranges.begin() + static_cast<std::ptrdiff_t>(count));
  return ranges.at(static_cast<std::size_t>(middle));
}

void demand_range(double value, double low, bool low_included, double high, const char* what) {
  demand(std::isfinite(value) && (low_included ? value >= low : value > low) && value <= high, what);
}

}  // namespace

std::optional<double> time_to_contact(const std::vector<Eigen::Vector2d>& points_m,
                                      const Footprint& footprint, double margin_m, const Twist2& twist,
                                      double horizon_s) {
  const Footprint bare = footprint.extended({});
  const Footprint grown = bare.padded(margin_m);
  const double speed_m_s =
      std::hypot(twist.vx, twist.vy) + std::abs(twist.wz) * grown.circumscribed_radius_m();
  const double reach_m = grown.circumscribed_radius_m() + speed_m_s * horizon_s;
  double first_s = kNever;
  for (const Eigen::Vector2d& point_m : points_m) {
    if (point_m.squaredNorm() > square(reach_m)) continue;
    first_s = std::min(first_s, time_of(bare.corners_m(), grown.corners_m(), point_m, twist));
  }
  if (first_s > horizon_s) return std::nullopt;
  return first_s;
}

std::vector<Eigen::Vector2d> surface_points(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!is_return(scan, scan.ranges[i])) continue;
    const double range_m = scan.ranges[i] < kSmoothed_m ? median_around(scan, i) : scan.ranges[i];
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const Pose2 end = compose(scan.base_T_sensor, {range_m * std::cos(angle), range_m * std::sin(angle), 0});
    points.emplace_back(end.x, end.y);
  }
  return points;
}

CollisionGuard::CollisionGuard(const GuardParams& params) : params_(params) {
  demand_range(params.min_time_s, 0, false, 10, "min_time_s must be above 0 and at most 10");
  demand_range(params.margin_m, 0, true, 0.5, "margin_m must be from 0 to 0.5");
  demand_range(params.max_age_s, 0, false, 10, "max_age_s must be above 0 and at most 10");
  demand_range(params.horizon_s, params.min_time_s, true, 10, "horizon_s must be from min_time_s to 10");
}

void CollisionGuard::set_points(std::vector<Eigen::Vector2d> points_m, double stamp_s) {
  points_m_ = std::move(points_m);
  points_m_.erase(std::remove_if(points_m_.begin(), points_m_.end(),
                                 [](const Eigen::Vector2d& point) { return !point.allFinite(); }),
                  points_m_.end());
  stamp_s_ = stamp_s;
}

GuardedCommand CollisionGuard::admit(const Footprint& footprint, const Twist2& velocity,
                                     const Twist2& command, double now_s) {
  if (!is_finite(command) || !is_finite(velocity))
    return {{}, GuardAction::kStopped, {}, "command or odometry is not finite: check who sends it"};
  if (is_zero(command)) return {command};
  if (!stamp_s_) return {{}, GuardAction::kNoScan, {}, "no scan yet: check the lidar and its topic"};
  const double age_s = now_s - *stamp_s_;
  if (!(std::abs(age_s) <= params_.max_age_s))
    return {{}, GuardAction::kNoScan, {}, "latest scan is too old: check the lidar and the clocks"};
  const Pose2 now_T_scan = inverse(advance({}, velocity, std::max(0.0, age_s)));
  near_m_.clear();
  near_m_.reserve(points_m_.size());
  for (const Eigen::Vector2d& point : points_m_) {
    const Pose2 at = compose(now_T_scan, {point.x(), point.y(), 0});
    near_m_.emplace_back(at.x, at.y);
  }
  GuardedCommand result{command};
  result.time_s = time_to_contact(near_m_, footprint, params_.margin_m, command, params_.horizon_s);
  if (!result.time_s || *result.time_s >= params_.min_time_s) return result;
  const double factor = *result.time_s / params_.min_time_s;
  if (factor < kStopFactor) {
    result.velocity = {};
    result.action = GuardAction::kStopped;
    result.reason = "an obstacle is close ahead: move away from it";
    return result;
  }
  result.velocity = {factor * command.vx, factor * command.vy, factor * command.wz};
  result.action = GuardAction::kSlowed;
  result.reason = "an obstacle is near ahead";
  return result;
}

}  // namespace extperfc::navigate
