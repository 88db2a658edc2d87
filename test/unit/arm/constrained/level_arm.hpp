#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/constrained_planner.hpp"
#include "extperfc/arm/path_constraint.hpp"

#include "test/unit/arm/collision/baxter.hpp"

namespace extperfc::arm::test {

inline const CollisionModel& left_arm() {
  static const CollisionModel model = group_model("left_arm");
  return model;
}

inline const CollisionModel& both_arms() {
  static const CollisionModel model = group_model("both_arms");
  return model;
}

inline PathConstraintParams on(const CollisionModel& model, std::vector<ToolConstraint> constraints,
                               JointVector reference = {}) {
  PathConstraintParams params;
  params.joints = model.joint_names();
  params.constraints = std::move(constraints);
  params.reference = std::move(reference);
  return params;
}

inline PathConstraint constraint_on(const CollisionModel& model, std::vector<ToolConstraint> constraints,
                                    JointVector reference = {}) {
  return PathConstraint::make(baxter(), on(model, std::move(constraints), std::move(reference))).value();
}

/// The left gripper's z axis points straight down.
inline ToolConstraint level() {
  ToolConstraint constraint{ToolConstraintKind::kKeepAxis, "left_gripper", "", Eigen::Vector3d::UnitZ(),
                            Pose::Identity()};
  constraint.target->linear() = Eigen::DiagonalMatrix<double, 3>(1.0, -1.0, -1.0);
  return constraint;
}

/// Angle of the left gripper's z axis from straight down [rad], by the collision model's kinematics.
inline double tilt_rad(const CollisionModel& model, const JointVector& joints) {
  const Eigen::Vector3d axis = model.link_pose(joints, "left_gripper")->linear().col(2);
  return std::atan2(axis.head<2>().norm(), -axis.z());
}

/// A free state of the left arm whose tool points down, in front of the robot.
inline JointVector random_level_state(const PathConstraint& constraint, CollisionChecker& checker, Rng& rng) {
  const auto& model = checker.model();
  while (true) {
    const auto state = constraint.project(random_state(model.limits(), rng), model.limits());
    if (!state || !checker.is_free(*state)) continue;
    if (model.link_pose(*state, "left_gripper")->translation().x() > 0.3) return *state;
  }
}

/// Straight segments looked at every `step_rad`.
template <typename Look>
void along(const std::vector<JointVector>& path, double step_rad, Look&& look) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const JointVector delta = path[i] - path[i - 1];
    const int steps = 1 + static_cast<int>(delta.norm() / step_rad);
    for (int s = 0; s <= steps; ++s)
      look(JointVector(path[i - 1] + delta * (static_cast<double>(s) / steps)));
  }
}

/// Whether Bullet finds every state of the polyline free.
inline bool free_all_along(CollisionChecker& checker, const std::vector<JointVector>& path) {
  bool free = true;
  along(path, 0.002, [&](const JointVector& state) { free = free && !checker.contact(state); });
  return free;
}

}  // namespace extperfc::arm::test
