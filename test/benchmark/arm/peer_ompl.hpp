#pragma once

#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::benchmark {

struct PeerPlan {
  bool solved{false};
  double seconds{0};  ///< search and simplification
  std::vector<arm::JointVector> waypoints;
};

/// The usual configuration of a ROS 1 robot: OMPL's RRTConnect with its default range, states asked of Bullet
/// every 1/64 rad along an edge, then OMPL's simplification.
[[nodiscard]] PeerPlan plan_with_ompl(arm::CollisionChecker& checker, const arm::JointVector& start,
                                      const arm::JointVector& goal, double timeout_s);

}  // namespace extperfc::benchmark
