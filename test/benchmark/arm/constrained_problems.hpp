#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/path_constraint.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

inline constexpr const char* kTool = "left_gripper";

/// A tool that points straight down at start and goal, and has to on the path.
struct LevelProblem {
  arm::CollisionModel model;  ///< the left arm; the right one stands
  arm::CollisionWorld world;
  arm::PathConstraint constraint;
  arm::JointVector start, goal;
};

/// `count` problems: a table, 3 to 6 boxes on it, start and goal free (for Bullet) with the tool over the
/// table and 0.3 m or more apart. The same seed gives the same problems.
[[nodiscard]] Result<std::vector<LevelProblem>> level_problems(std::uint64_t seed, int count);

/// Angle between the tool's axis and straight down [rad], by the collision model's kinematics.
[[nodiscard]] double tilt_rad(const arm::CollisionModel& model, const arm::JointVector& joints);

}  // namespace extperfc::benchmark
