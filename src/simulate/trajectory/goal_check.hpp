#pragma once

#include <string>
#include <vector>

#include "extperfc/simulate/joint_spline.hpp"
#include "extperfc/simulate/trajectory_follower.hpp"
#include "extperfc/simulate/trajectory_goal.hpp"

namespace extperfc::simulate {

/// A goal that can be followed, in the order of the follower's joints.
struct CheckedGoal {
  std::vector<JointKnot> knots;  ///< times on the caller's clock; those that are over at `now` are left out
  double start_s{0};
  double goal_time_s{0};
  MotionBounds path_bounds;
  MotionBounds goal_bounds;
};

/// Checks everything that can be wrong with a goal before anything moves.
[[nodiscard]] TrajectoryResult<CheckedGoal> check_goal(const TrajectoryGoal& goal,
                                                       const std::vector<FollowedJoint>& joints,
                                                       const TrajectoryFollowerParams& params, double now_s);

/// A number for messages: three digits behind the point.
[[nodiscard]] std::string to_text(double value);

}  // namespace extperfc::simulate
