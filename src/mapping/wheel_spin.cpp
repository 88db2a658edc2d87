#include "mapping/wheel_spin.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include <Eigen/Geometry>

namespace extperfc::mapping {

namespace {

constexpr int kBesideSteps = 10;  // that places are looked at beyond both ends
constexpr int kSameSteps = 2;     // nearer to odometry's place nothing is to be mended
constexpr int kApartSteps = 8;    // nearer places explain the same points

/// The points of surfaces that face along a direction of the map, one way or the other.
ScanPoints facing_along(const ScanPoints& points, const Pose2& map_T_base, const Eigen::Vector2d& along) {
  constexpr float kFaces = 0.5F;  // cosine
  const Eigen::Vector2f in_base = (Eigen::Rotation2Dd(-map_T_base.yaw) * along).cast<float>();
  ScanPoints facing;
  facing.scanner = points.scanner;
  std::copy_if(points.surface.begin(), points.surface.end(), std::back_inserter(facing.surface),
               [&](const SurfacePoint& point) { return std::abs(point.normal.dot(in_base)) > kFaces; });
  return facing;
}

/// How far each value stands above both sides, as far as `reach` places away. What a person who walks leaves
/// in a map stretches over many places and tells none of them.
std::vector<double> heights_of_peaks(const std::vector<double>& values, std::ptrdiff_t reach) {
  std::vector<double> heights(values.size(), 0.0);
  const auto end = static_cast<std::ptrdiff_t>(values.size()) - reach;
  for (std::ptrdiff_t i = reach; i < end; ++i) {
    const auto at = values.begin() + i;
    const double side =
        std::max(*std::min_element(at - reach, at), *std::min_element(at + 1, at + 1 + reach));
    heights[static_cast<std::size_t>(i)] = std::max(0.0, *at - side);
  }
  return heights;
}

/// The points in groups, one behind the other along a direction: a door frame or a person each.
std::vector<ScanPoints> groups_along(ScanPoints points, const Pose2& map_T_base,
                                     const Eigen::Vector2d& along) {
  constexpr float kApartM = 0.5F;
  const Eigen::Vector2f in_base = (Eigen::Rotation2Dd(-map_T_base.yaw) * along).cast<float>();
  const auto ahead = [&](const SurfacePoint& point) { return point.position.dot(in_base); };
  std::sort(points.surface.begin(), points.surface.end(),
            [&](const SurfacePoint& a, const SurfacePoint& b) { return ahead(a) < ahead(b); });
  std::vector<ScanPoints> groups;
  for (const SurfacePoint& point : points.surface) {
    if (groups.empty() || ahead(point) - ahead(groups.back().surface.back()) > kApartM)
      groups.push_back({{}, {}, points.scanner});
    groups.back().surface.push_back(point);
  }
  return groups;
}

/// The pose shifted along a direction.
Pose2 shifted(const Pose2& pose, const Eigen::Vector2d& along, double by_m) {
  return {pose.x + by_m * along.x(), pose.y + by_m * along.y(), pose.yaw};
}

}  // namespace

WheelSpin::Verdict WheelSpin::add(const ScanPoints& points, const Pose2& by_odometry) {
  const double moved_m = along_.dot(Eigen::Vector2d(by_odometry.x - from_.x, by_odometry.y - from_.y));
  const int wheels = static_cast<int>(std::lround(moved_m / kPlaceStepM));
  if (std::abs(wheels) > kReachSteps) return Verdict::kMoves;  // nothing decides: as wheels say
  const auto place = [&](int step) { return shifted(by_odometry, along_, kPlaceStepM * (step - wheels)); };
  const int first = std::min(0, wheels);
  const int last = std::max(0, wheels);
  const ScanPoints facing = facing_along(points, by_odometry, along_);
  std::vector<double> seen;  // points that fit, at each step
  for (int step = first - kBesideSteps; step <= last + kBesideSteps; ++step)
    seen.push_back(agreement(before_, facing, place(step)).on_surface);
  const std::vector<double> peaks = heights_of_peaks(seen, kBesideSteps);
  const auto peak = [&](int step) {
    const int index = step - first + kBesideSteps;
    return peaks[static_cast<std::size_t>(index)];
  };
  // Places beyond both ends are not looked at; they count as much as where the wheels have the robot.
  for (int step = -kReachSteps; step <= kReachSteps; ++step)
    standing(step) += step < first || step > last ? peak(wheels) : peak(step);
  facing_ += static_cast<double>(facing.surface.size());
  ++scans_;
  int best = wheels;
  for (int step = first; step <= last; ++step)
    if (std::abs(step - wheels) > kSameSteps && (best == wheels || standing(step) > standing(best)))
      best = step;
  Verdict verdict = best == wheels ? Verdict::kOpen : judge(standing(best), standing(wheels));
  if (verdict == Verdict::kMoves && std::abs(wheels) < kApartSteps) verdict = Verdict::kOpen;
  if (verdict == Verdict::kStands && !several_agree(facing, place(best), by_odometry))
    verdict = Verdict::kOpen;
  constexpr double kSigmaRad = 0.12;
  constexpr double kReachOfPlaceM = 0.25;
  if (verdict == Verdict::kStands)
    place_ = match(before_, points, place(best), {place(best), kPlaceStepM, kSigmaRad}, kReachOfPlaceM);
  return verdict;
}

/// One or two people who stand or walk in the right manner may say anything.
bool WheelSpin::several_agree(const ScanPoints& facing, const Pose2& stands, const Pose2& moves) const {
  constexpr int kSeveral = 3;
  constexpr double kClearly = 0.5;  // points
  int agree = 0;
  for (const ScanPoints& group : groups_along(facing, moves, along_))
    if (agreement(before_, group, stands).on_surface > agreement(before_, group, moves).on_surface + kClearly)
      ++agree;
  return agree >= kSeveral;
}

WheelSpin::Verdict WheelSpin::judge(double stands, double moves) const {
  constexpr int kMinScans = 4;
  constexpr double kEnough = 6;      // points ...
  constexpr double kFraction = 0.1;  // ... and this fraction of all that face along the corridor
  constexpr double kClearly = 1.5;
  constexpr double kNearly = 1.1;
  if (scans_ >= kMinScans && stands > std::max({kEnough, kFraction * facing_, kClearly * moves}))
    return Verdict::kStands;
  return moves > kEnough && stands < kNearly * moves ? Verdict::kMoves : Verdict::kOpen;
}

}  // namespace extperfc::mapping
