#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/collision_world.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

/// A problem for both arms of Baxter; the frame of its objects is Baxter's `base`.
struct ArmProblem {
  int index{0};
  arm::JointVector start, goal;  ///< 14 values: left s0 s1 e0 e1 w0 w1 w2, then right [rad]
  std::vector<arm::WorldObject> objects;
};

/// Errors: no such file, a line that does not fit its kind (with its number), an unfinished problem.
[[nodiscard]] Result<std::vector<ArmProblem>> read_problems(const std::filesystem::path& file);

enum class ArmGroup { kLeft, kBoth };

/// The values of the group's joints.
[[nodiscard]] arm::JointVector states_of(const arm::JointVector& both, ArmGroup group);

/// The mobile Baxter and the world of a problem, with the contacts that its goal needs allowed. A right arm
/// that is not in the group stands at its start.
struct ProblemScene {
  arm::CollisionModel model;
  arm::CollisionWorld world;
  arm::JointPositions standing;  ///< every joint that matters, at the problem's start, grippers open
};
[[nodiscard]] Result<ProblemScene> make_scene(const ArmProblem& problem, ArmGroup group);

/// The mobile Baxter's arms, with the accelerations of config/arm.yaml's default.
[[nodiscard]] const Result<arm::RobotArms>& baxter_arms();

}  // namespace extperfc::benchmark
