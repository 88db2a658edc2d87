#pragma once

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/path.hpp"

namespace extperfc::navigate::contract {

/// Starts and ends right, steps are small, and it touches nothing on and between its poses.
inline void expect_drivable(const CostGrid& grid, const Footprint& footprint, const Path& path,
                            const Pose2& start, const Pose2& goal) {
  ASSERT_GE(path.poses.size(), 1U);
  const auto apart = [](const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); };
  EXPECT_LT(apart(path.poses.front(), start), 1e-9);
  EXPECT_LT(std::abs(wrap_angle(path.poses.front().yaw - start.yaw)), 1e-9);
  EXPECT_LT(apart(path.poses.back(), goal), 1e-9);
  EXPECT_LT(std::abs(wrap_angle(path.poses.back().yaw - goal.yaw)), 1e-9);
  double longest_m = 0;
  double longest_rad = 0;
  int touching = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    longest_m = std::max(longest_m, apart(path.poses[i - 1], path.poses[i]));
    longest_rad = std::max(longest_rad, std::abs(wrap_angle(path.poses[i].yaw - path.poses[i - 1].yaw)));
    touching += contact_along(grid, footprint, path.poses[i - 1], path.poses[i]) != Contact::kFree ? 1 : 0;
  }
  EXPECT_LE(longest_m, 0.1);
  EXPECT_LE(longest_rad, 0.2);
  EXPECT_EQ(0, touching);
  EXPECT_TRUE(std::isfinite(path.cost));
  EXPECT_GE(path.cost, 0.99 * length_m(path));
}

}  // namespace extperfc::navigate::contract
