#include "navigate/global/free_pose.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::navigate {

std::vector<Pose2> free_poses(const CostGrid& costs, const FootprintRefiner& footprint, const Pose2& goal,
                              double tolerance_m, std::size_t max_count, const PlanClock& clock) {
  std::vector<Pose2> around;
  const int reach = static_cast<int>(std::floor(tolerance_m / costs.resolution_m));
  for (int row = -reach; row <= reach; ++row)
    for (int column = -reach; column <= reach; ++column)
      around.push_back({goal.x + column * costs.resolution_m, goal.y + row * costs.resolution_m, goal.yaw});
  const auto distance_m = [](const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); };
  std::stable_sort(around.begin(), around.end(),
                   [&](const Pose2& a, const Pose2& b) { return distance_m(a, goal) < distance_m(b, goal); });
  std::vector<Pose2> found;
  for (const Pose2& pose : around) {
    if (distance_m(pose, goal) > tolerance_m || found.size() == max_count || clock.ended()) break;
    const bool near = std::any_of(found.begin(), found.end(), [&](const Pose2& other) {
      return distance_m(pose, other) < 0.25 * tolerance_m;
    });
    const auto cell = costs.cell_of({pose.x, pose.y});
    if (!near && cell && costs.at(*cell) != kInscribedCost && footprint.is_free(pose)) found.push_back(pose);
  }
  return found;
}

}  // namespace extperfc::navigate
