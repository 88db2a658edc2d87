#include "navigate/global/passage_line.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace extperfc::navigate {

namespace {

constexpr int kYaws = 24;  // to either side
constexpr double kYawStep_rad = 0.025;
constexpr double kPrice_m_per_rad = 0.03;  // of a rotation from the pose's heading

/// Middles of the blocked cells around a place, from it.
std::vector<Eigen::Vector2d> blocked_around(const CostGrid& costs, const BlockedCosts& is_blocked,
                                            const Eigen::Vector2d& place, double reach_m) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_m);
  const Cell low = costs.cell_around(place - reach);
  const Cell high = costs.cell_around(place + reach);
  const CellBox box = CellBox{low, {high.column + 1, high.row + 1}}.clipped(costs.box());
  std::vector<Eigen::Vector2d> middles;
  for (int row = box.min.row; row < box.max.row; ++row)
    for (int column = box.min.column; column < box.max.column; ++column)
      if (is_blocked(costs.at({column, row}))) middles.push_back(costs.middle_of({column, row}) - place);
  return middles;
}

/// Distances from the line to what is nearest on its left and on its right.
struct Strip {
  double left_m;
  double right_m;
};

Strip strip_beside(const std::vector<Eigen::Vector2d>& blocked, double yaw, double reach_m) {
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  Strip strip{reach_m, reach_m};
  for (const Eigen::Vector2d& middle : blocked) {
    if (std::abs(ahead.dot(middle)) > reach_m) continue;
    const double beside_m = left.dot(middle);
    double& side_m = beside_m > 0 ? strip.left_m : strip.right_m;
    side_m = std::min(side_m, std::abs(beside_m));
  }
  return strip;
}

}  // namespace

Pose2 widest_line(const CostGrid& costs, const BlockedCosts& is_blocked, const Pose2& within,
                  double reach_m) {
  const auto blocked = blocked_around(costs, is_blocked, {within.x, within.y}, 1.5 * reach_m);
  Pose2 best = within;
  double best_m = 0;
  for (int step = -kYaws; step <= kYaws; ++step) {
    const double yaw = within.yaw + step * kYawStep_rad;
    const Strip strip = strip_beside(blocked, yaw, reach_m);
    const double worth_m = strip.left_m + strip.right_m - kPrice_m_per_rad * std::abs(step) * kYawStep_rad;
    if (worth_m <= best_m) continue;
    best_m = worth_m;
    const double beside_m = 0.5 * (strip.left_m - strip.right_m);
    best = {within.x - beside_m * std::sin(yaw), within.y + beside_m * std::cos(yaw), wrap_angle(yaw)};
  }
  return best;
}

}  // namespace extperfc::navigate
