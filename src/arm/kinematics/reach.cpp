#include "arm/kinematics/reach.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::arm {
namespace {

/// Where on its axis each joint is measured from [m].
using Shifts = std::array<double, kMaxJoints>;

/// From the chosen point of joint i - 1 to that of joint i.
double distance(const ChainGeometry& geometry, const Shifts& shifts, int i) {
  const ChainLink& link = geometry.links[i];
  return (link.offset_m + shifts[i] * link.rotation.col(2) - shifts[i - 1] * Eigen::Vector3d::UnitZ()).norm();
}

/// The distances that depend on joint i's point.
double beside(const ChainGeometry& geometry, const Shifts& shifts, int i) {
  return (i > 0 ? distance(geometry, shifts, i) : 0) +
         (i + 1 < geometry.count ? distance(geometry, shifts, i + 1) : 0);
}

/// The smallest sum for joint i, which is convex in its point, by golden sections.
void improve(const ChainGeometry& geometry, Shifts& shifts, int i) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSections = 60;
  const double radius = beside(geometry, shifts, i);  // farther away the sum is larger
  double low = shifts[i] - radius;
  double high = shifts[i] + radius;
  const auto at = [&](double shift) {
    shifts[i] = shift;
    return beside(geometry, shifts, i);
  };
  for (int section = 0; section < kSections; ++section) {
    const double left = high - kGolden * (high - low);
    const double right = low + kGolden * (high - low);
    if (at(left) < at(right))
      high = right;
    else
      low = left;
  }
  shifts[i] = 0.5 * (low + high);
}

Shifts shortest(const ChainGeometry& geometry) {
  constexpr int kRounds = 20;  // any number gives a valid bound
  Shifts shifts{};
  for (int round = 0; round < kRounds; ++round)
    for (int i = 0; i < geometry.count; ++i) improve(geometry, shifts, i);
  return shifts;
}

}  // namespace

Reach find_reach(const ChainGeometry& geometry, const JointLimits& limits) {
  const Shifts shifts = shortest(geometry);
  const int last = geometry.count - 1;
  Reach reach;
  reach.anchor_m = geometry.links[0].offset_m + shifts[0] * geometry.links[0].rotation.col(2);
  const ChainLink& hand = geometry.links[geometry.count];
  reach.wrist_m = hand.rotation.transpose() * (shifts[last] * Eigen::Vector3d::UnitZ() - hand.offset_m);
  for (int i = 1; i < geometry.count; ++i) reach.length_m += distance(geometry, shifts, i);
  for (int i = 0; i < geometry.count; ++i)
    if (geometry.prismatic[i])
      reach.length_m += std::max(std::abs(limits.lower[i]), std::abs(limits.upper[i]));
  return reach;
}

bool is_beyond(const Reach& reach, const Pose& target, const IkTolerance& tolerance) {
  constexpr double kRounding = 1e-9;
  const double lever = reach.wrist_m.norm();
  const double swing = lever * std::min(2.0, tolerance.orientation_rad.norm());
  const double room = reach.length_m + tolerance.position_m.norm() + kRounding;
  const double wrist = (target * reach.wrist_m - reach.anchor_m).norm();
  const double tip = (target.translation() - reach.anchor_m).norm();
  return wrist > room + swing || tip > room + lever;
}

}  // namespace extperfc::arm
