#include "ros/robot/tuck_plan.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ros/robot/names.hpp"

namespace extperfc::ros_robot {

using simulate::ArmValues;
using simulate::kArmJoints;
using simulate::Side;

namespace {

constexpr double kNear = 0.25;         ///< of every joint: it is in that pose [rad]
constexpr double kShortestMove = 0.2;  ///< [s]

/// The right arm mirrors the left one.
ArmValues mirrored(ArmValues left, Side side) {
  if (side == Side::kRight)
    for (const int odd : {0, 2, 4, 6}) left[odd] = -left[odd];
  return left;
}

double distance(const ArmValues& a, const ArmValues& b) {
  double largest = 0;
  for (int i = 0; i < kArmJoints; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

std::vector<ArmValues> path_of(bool tuck, const ArmValues& from, Side side) {
  const auto tucked = tucked_pose(side);
  const auto untucked = untucked_pose(side);
  const auto neutral = mirrored({0, -0.55, 0, 0.75, 0, 1.26, 0}, side);
  const bool is_known = distance(from, tucked) < kNear || distance(from, untucked) < kNear;
  std::vector<ArmValues> path;
  if (!is_known) path = {neutral, untucked};
  if (tuck) path.push_back(tucked);
  if (!tuck && is_known) path.push_back(untucked);
  return path;
}

/// Of a cubic from rest to rest: its greatest speed is 1.5 d / t, its greatest acceleration 6 d / t^2.
double duration(double distance_rad, const TuckSpeed& speed) {
  return std::max({kShortestMove, 1.5 * distance_rad / speed.velocity_rad_s,
                   std::sqrt(6 * distance_rad / speed.accel_rad_s2)});
}

simulate::TrajectoryPoint at_rest(double time_s, const ArmValues& pose) {
  return {time_s, {pose.begin(), pose.end()}, std::vector<double>(kArmJoints, 0.0), {}};
}

}  // namespace

ArmValues tucked_pose(Side side) {
  return mirrored({-1.0, -2.07, 3.0, 2.55, 0.0, 0.01, 0.0}, side);
}

ArmValues untucked_pose(Side side) {
  return mirrored({-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5}, side);
}

std::array<simulate::TrajectoryGoal, 2> plan_tuck(bool tuck, const std::array<ArmValues, 2>& from,
                                                  const TuckSpeed& speed) {
  std::array paths{path_of(tuck, from[0], Side::kLeft), path_of(tuck, from[1], Side::kRight)};
  const auto poses = std::max(paths[0].size(), paths[1].size());
  for (const Side side : simulate::kSides) {
    auto& path = paths[static_cast<int>(side)];
    path.insert(path.begin(), poses - path.size(), from[static_cast<int>(side)]);
  }
  std::array<simulate::TrajectoryGoal, 2> goals;
  auto at = from;
  double time_s = 0;
  for (std::size_t i = 0; i < poses; ++i) {
    time_s += duration(std::max(distance(at[0], paths[0][i]), distance(at[1], paths[1][i])), speed);
    at = {paths[0][i], paths[1][i]};
    for (int side = 0; side < 2; ++side) goals[side].points.push_back(at_rest(time_s, at[side]));
  }
  for (const Side side : simulate::kSides)
    for (int i = 0; i < kArmJoints; ++i) goals[static_cast<int>(side)].joints.push_back(joint_name(side, i));
  return goals;
}

}  // namespace extperfc::ros_robot
