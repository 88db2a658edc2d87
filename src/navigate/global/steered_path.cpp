#include "navigate/global/steered_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Core>

#include "navigate/global/pose_search.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kSamePlace_m = 1e-6;
constexpr double kMaxOff_rad = 1.8;  // between a passage's direction and the motions towards and from it
/// Lengths along a passage's line, before and behind its middle.
constexpr std::array<double, 7> kApproaches_m{0.35, 0.5, 0.65, 0.8, 1.0, 1.25, 1.6};

constexpr double kTightPrice_m = 1.0;  // of motions before and behind a narrow place without room beside them

constexpr double kMinRotation_rad = 0.05;
constexpr double kMaxRotation_rad = 2.2;
constexpr double kMaxCurvature_per_m = 2.5;
constexpr double kCurveStep_m = 0.03;
/// Lengths of a path to either side of a corner, which a curve replaces.
constexpr std::array<double, 6> kCurves_m{1.2, 0.85, 0.6, 0.42, 0.3, 0.2};

Eigen::Vector2d place_of(const Pose2& pose) {
  return {pose.x, pose.y};
}

Eigen::Vector2d direction_of(double yaw) {
  return {std::cos(yaw), std::sin(yaw)};
}

double yaw_change(const Pose2& from, const Pose2& to) {
  return wrap_angle(to.yaw - from.yaw);
}

/// Poses between two, whose headings differ from the motion's; and its price.
struct Leg {
  Pose2 leaves;
  Pose2 arrives;
  double price_m{std::numeric_limits<double>::infinity()};
};

/// Rotate, drive, rotate; empty where it does not pass.
std::optional<Leg> leg_between(const Pose2& from, const Pose2& to, const MotionCheck& passes) {
  const Eigen::Vector2d motion = place_of(to) - place_of(from);
  const double yaw = motion.norm() > 1e-3 ? std::atan2(motion.y(), motion.x()) : to.yaw;
  const Leg leg{{from.x, from.y, yaw},
                {to.x, to.y, yaw},
                motion.norm() + kRotationPrice_m_per_rad * (std::abs(wrap_angle(yaw - from.yaw)) +
                                                            std::abs(wrap_angle(yaw - to.yaw)))};
  if (!passes(from, leg.leaves) || !passes(leg.leaves, leg.arrives) || !passes(leg.arrives, to))
    return std::nullopt;
  return leg;
}

Pose2 pose_between(const Pose2& a, const Pose2& b, double part) {
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), wrap_angle(a.yaw + part * yaw_change(a, b))};
}

bool drives_ahead(const Pose2& from, const Pose2& to) {
  const Eigen::Vector2d motion = place_of(to) - place_of(from);
  return motion.norm() > kSamePlace_m && motion.normalized().dot(direction_of(to.yaw)) > 0.9;
}

/// A rotation in place between the poses `first` and `last`.
struct Corner {
  std::size_t first;
  std::size_t last;
};

std::optional<Corner> next_corner(const std::vector<Pose2>& poses, std::size_t from) {
  for (std::size_t i = from; i + 1 < poses.size(); ++i) {
    if (distance_m(poses[i], poses[i + 1]) > kSamePlace_m) continue;
    std::size_t last = i + 1;
    while (last + 1 < poses.size() && distance_m(poses[last], poses[last + 1]) < kSamePlace_m) ++last;
    return Corner{i, last};
  }
  return std::nullopt;
}

/// Where a path that is driven ahead is `length_m` before (step -1) or after (step 1) the pose `at`; `bound`
/// is the last pose that may be reached. Empty: it is shorter, or driven otherwise.
struct Reached {
  Pose2 pose;
  std::size_t beyond;  ///< the first pose that is farther away, or `bound`
};
std::optional<Reached> reach(const std::vector<Pose2>& poses, std::size_t at, std::size_t bound, int step,
                             double length_m) {
  double passed_m = 0;
  while (at != bound) {
    const std::size_t next = step > 0 ? at + 1 : at - 1;
    const double motion_m = distance_m(poses[at], poses[next]);
    if (!(step > 0 ? drives_ahead(poses[at], poses[next]) : drives_ahead(poses[next], poses[at])))
      return std::nullopt;
    if (passed_m + motion_m >= length_m)
      return Reached{pose_between(poses[at], poses[next], (length_m - passed_m) / motion_m), next};
    passed_m += motion_m;
    at = next;
  }
  return std::nullopt;
}

/// A cubic Bezier curve that leaves and arrives with the poses' headings; empty where it bends too much.
std::vector<Pose2> curve(const Pose2& from, const Pose2& to) {
  const Eigen::Vector2d a = place_of(from);
  const Eigen::Vector2d d = place_of(to);
  const Eigen::Vector2d chord = d - a;
  if (chord.norm() < kCurveStep_m) return {};
  const double along = std::atan2(chord.y(), chord.x());
  const double angle = std::abs(wrap_angle(along - from.yaw)) + std::abs(wrap_angle(to.yaw - along));
  if (angle > kMaxRotation_rad) return {};
  // The handles of an arc of that angle.
  const double cosine = std::cos(0.25 * angle);
  const double handle_m = chord.norm() / (3 * cosine * cosine);
  const Eigen::Vector2d b = a + handle_m * direction_of(from.yaw);
  const Eigen::Vector2d c = d - handle_m * direction_of(to.yaw);
  const int steps = static_cast<int>(std::ceil(1.2 * chord.norm() / kCurveStep_m));
  std::vector<Pose2> poses{from};
  for (int k = 1; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    const double u = 1 - t;
    const Eigen::Vector2d at = u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d;
    const Eigen::Vector2d heading = u * u * (b - a) + 2 * u * t * (c - b) + t * t * (d - c);
    const Pose2 pose = k < steps ? Pose2{at.x(), at.y(), std::atan2(heading.y(), heading.x())} : to;
    if (std::abs(yaw_change(poses.back(), pose)) > kMaxCurvature_per_m * distance_m(poses.back(), pose))
      return {};
    poses.push_back(pose);
  }
  return poses;
}

bool passes_all(const std::vector<Pose2>& poses, const MotionCheck& passes) {
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (!passes(poses[i - 1], poses[i])) return false;
  return !poses.empty();
}

}  // namespace

std::optional<std::vector<Pose2>> straight_passage(const Pose2& first, const Pose2& middle, const Pose2& last,
                                                   const MotionCheck& passes,
                                                   const MotionCheck& passes_with_room,
                                                   const MotionCheck& passes_narrow) {
  const Eigen::Vector2d axis = direction_of(middle.yaw);
  const auto on_line = [&](double ahead_m) {
    return Pose2{middle.x + ahead_m * axis.x(), middle.y + ahead_m * axis.y(), middle.yaw};
  };
  std::optional<Leg> to;
  std::optional<Leg> from;
  const auto leg = [&](const Pose2& start, const Pose2& end) {
    auto roomy = leg_between(start, end, passes_with_room);
    if (roomy) return roomy;
    auto tight = leg_between(start, end, passes);
    if (tight) tight->price_m += kTightPrice_m;
    return tight;
  };
  const auto offer = [&](std::optional<Leg>& best, const std::optional<Leg>& made, double line_m) {
    if (!made || made->price_m + line_m >= (best ? best->price_m : std::numeric_limits<double>::infinity()))
      return;
    if (std::abs(wrap_angle(made->leaves.yaw - middle.yaw)) > kMaxOff_rad) return;
    best = made;
    best->price_m += line_m;
  };
  for (const double length_m : kApproaches_m) {
    const Pose2 before = on_line(-length_m);
    if (passes_narrow(before, middle)) offer(to, leg(first, before), length_m);
    const Pose2 behind = on_line(length_m);
    if (passes_narrow(middle, behind)) offer(from, leg(behind, last), length_m);
  }
  if (!to || !from) return std::nullopt;
  const auto on_axis = [&](const Pose2& pose) { return Pose2{pose.x, pose.y, middle.yaw}; };
  return std::vector<Pose2>{
      first,        to->leaves,    to->arrives, on_axis(to->arrives), on_axis(from->leaves),
      from->leaves, from->arrives, last};
}

std::vector<Pose2> round_corners(const std::vector<Pose2>& poses, const MotionCheck& passes) {
  std::vector<Pose2> out = poses;
  std::size_t done = 0;  // nothing before this pose is changed any more
  for (auto corner = next_corner(out, 0); corner; corner = next_corner(out, done)) {
    const bool starts = corner->first == 0;
    const bool ends = corner->last + 1 == out.size();
    const std::size_t before_corner = done;
    done = corner->last;
    const double rotation = std::abs(yaw_change(out[corner->first], out[corner->last]));
    if ((starts && ends) || rotation < kMinRotation_rad || rotation > kMaxRotation_rad) continue;
    const auto following = next_corner(out, corner->last);
    const std::size_t bound = following ? following->first : out.size() - 1;
    for (const double length_m : kCurves_m) {
      // The next corner needs as much of what lies between.
      const bool leaves_room = !following || following->last + 1 == out.size() ||
                               reach(out, corner->last, bound, 1, 2 * length_m).has_value();
      const auto from =
          starts ? Reached{out.front(), 0} : reach(out, corner->first, before_corner, -1, length_m);
      const auto to =
          ends ? Reached{out.back(), out.size() - 1} : reach(out, corner->last, bound, 1, length_m);
      if (!leaves_room || !from || !to) continue;
      const std::vector<Pose2> rounded = curve(from->pose, to->pose);
      if (!passes_all(rounded, passes)) continue;
      const auto first = starts ? std::size_t{0} : from->beyond + 1;
      const auto last = ends ? out.size() : to->beyond;
      out.erase(out.begin() + static_cast<std::ptrdiff_t>(first),
                out.begin() + static_cast<std::ptrdiff_t>(last));
      out.insert(out.begin() + static_cast<std::ptrdiff_t>(first), rounded.begin(), rounded.end());
      done = first + rounded.size() - 1;
      break;
    }
  }
  return out;
}

}  // namespace extperfc::navigate
