#include "extperfc/navigate/near_memory.hpp"

#include <algorithm>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kReplaced_m = 0.04;  // what a scan shows so near to a remembered point takes its place
constexpr double kDeep_m = 0.05;      // deeper inside the footprint no obstacle can be
constexpr double kDoubt_m = 0.015;    // noise of the last scan that showed it, and odometry since then
constexpr double kBeside_m = 0.15;    // beyond the strip: may be in it at the next scan

bool is_in_strip(const Eigen::Vector2d& point_m, const Footprint& footprint, double outside_m) {
  if (point_m.squaredNorm() > square(footprint.circumscribed_radius_m() + outside_m)) return false;
  const auto& corners_m = footprint.corners_m();
  return distance_to_edges_m(corners_m, point_m) <= (contains(corners_m, point_m) ? kDeep_m : outside_m);
}

Eigen::Vector2d moved(const Pose2& pose, const Eigen::Vector2d& point_m) {
  const Pose2 place = compose(pose, {point_m.x(), point_m.y(), 0});
  return {place.x, place.y};
}

}  // namespace

NearMemory::NearMemory(double reach_m) : reach_m_(reach_m) {
  demand(reach_m >= 0 && reach_m <= 0.5, "reach_m must be from 0 to 0.5");
}

void NearMemory::complete(std::vector<Eigen::Vector2d>& points_m, const Footprint& footprint,
                          const Pose2& odom_T_base) {
  if (reach_m_ <= 0 || !is_finite(odom_T_base)) return;
  std::vector<Eigen::Vector2d> near_m;
  for (const Eigen::Vector2d& point_m : points_m)
    if (is_in_strip(point_m, footprint, reach_m_ + kBeside_m)) near_m.push_back(point_m);
  const Pose2 base_T_odom = inverse(odom_T_base);
  for (const Eigen::Vector2d& kept_m : kept_m_) {
    const Eigen::Vector2d here_m = moved(base_T_odom, kept_m);
    const auto is_same = [&here_m](const Eigen::Vector2d& other_m) {
      return (other_m - here_m).squaredNorm() < square(kReplaced_m);
    };
    if (!is_in_strip(here_m, footprint, reach_m_) || std::any_of(near_m.begin(), near_m.end(), is_same))
      continue;
    near_m.push_back(here_m);
    points_m.push_back(here_m - kDoubt_m * here_m.normalized());
  }
  kept_m_.clear();
  for (const Eigen::Vector2d& point_m : near_m) kept_m_.push_back(moved(odom_T_base, point_m));
}

}  // namespace extperfc::navigate
