#pragma once

#include <functional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_pipeline.hpp"
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/arm/status.hpp"

#include "arm/cartesian/arm_in_group.hpp"

namespace extperfc::arm {

struct GoalSearch {
  int samples{12};     ///< per tool
  double time_s{0.5};  ///< wall time for all of it, at most
  std::uint64_t seed{1};
  std::function<bool()> stop;  ///< may be empty
  bool collisions{true};       ///< false: solutions that collide count too
};

/// Joint values of the group that bring every target's link to its pose, free of collisions, the nearest to
/// `start` first; at most `samples` of them. Joints that move no target's link stay as in `start`.
/// Errors: kInvalidRequest (two targets for one arm, a link that the group does not move, a bad pose),
/// kGoalUnreachable, kGoalInCollision, kPlanningTimeout, kCancelled.
[[nodiscard]] tl::expected<std::vector<JointVector>, Status> find_goals(
    const RobotArms& arms, const ArmGroup& group, const std::vector<ToolTarget>& targets,
    const JointVector& start, CollisionChecker& checker, const GoalSearch& search);

/// The chain from the robot's root to the link, in the group. An empty link means the group's only tip.
/// Error: kInvalidRequest.
[[nodiscard]] tl::expected<ArmInGroup, Status> chain_to(const RobotArms& arms, const ArmGroup& group,
                                                        const std::string& link);

}  // namespace extperfc::arm
