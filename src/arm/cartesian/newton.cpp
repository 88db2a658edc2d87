#include "arm/cartesian/newton.hpp"

#include <array>
#include <cmath>

#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm {

namespace {

constexpr int kMaxSteps = 12;
constexpr double kConverged = 1e-8;  // [m], [rad]
constexpr double kDamping = 1e-9;    // [m^2], [rad^2]

using Held = std::array<bool, kMaxJoints>;

// Holds joints that `change` would carry past their limits, at them; false when no further one was found.
bool hold_leavers(const ArmChain& chain, const JointVector& joints, JointVector& change, Held& held) {
  const auto& [lower, upper] = chain.limits();
  bool found = false;
  for (int j = 0; j < joints.size(); ++j) {
    if (held[j]) continue;
    const double next = joints[j] + change[j];
    if (next >= lower[j] && next <= upper[j]) continue;
    held[j] = found = true;
    change[j] = (next < lower[j] ? lower[j] : upper[j]) - joints[j];
  }
  return found;
}

// J^+ wish + (I - J^+ J) urge over the joints that are not held; those keep what `change` says.
void fill_free(const Jacobian& columns, const Vector6& wish, const JointVector& urge, const Held& held,
               JointVector& change) {
  Jacobian free = columns;
  Vector6 rest = wish;
  JointVector pull = urge;
  for (int j = 0; j < change.size(); ++j) {
    if (!held[j]) continue;
    rest -= columns.col(j) * change[j];
    free.col(j).setZero();
    pull[j] = 0;
  }
  rest -= free * pull;
  const JointVector step = pull + min_norm_change(free, rest, kDamping);
  for (int j = 0; j < change.size(); ++j)
    if (!held[j]) change[j] = step[j];
}

JointVector bounded_step(const ArmChain& chain, const JointVector& joints, const Jacobian& columns,
                         const Vector6& wish, const JointVector& urge) {
  Held held{};
  JointVector change = JointVector::Zero(joints.size());
  do {
    fill_free(columns, wish, urge, held, change);
  } while (hold_leavers(chain, joints, change, held));
  return change;
}

}  // namespace

bool converge(const ArmChain& chain, const Pose& target, bool limited, JointVector& guess) {
  const JointVector none = JointVector::Zero(guess.size());
  for (int i = 0; i <= kMaxSteps; ++i) {
    const Vector6 error = pose_difference(target, chain.forward(guess));
    if (error.cwiseAbs().maxCoeff() < kConverged) return true;
    const Jacobian columns = chain.jacobian(guess);
    if (limited)
      guess += bounded_step(chain, guess, columns, error, none);
    else
      guess += min_norm_change(columns, error, kDamping);
    if (!guess.allFinite()) return false;
  }
  return false;
}

JointVector step_towards(const ArmChain& chain, const JointVector& joints, const Vector6& wish,
                         const JointVector& urge) {
  return bounded_step(chain, joints, chain.jacobian(joints), wish, urge);
}

JointVector self_motion(const ArmChain& chain, const JointVector& joints, const JointVector& near) {
  const Jacobian columns = chain.jacobian(joints);
  const Vector6 moved = columns * near;
  const JointVector rest = near - min_norm_change(columns, moved, kDamping);
  const double norm = rest.norm();
  return norm > 1e-6 ? JointVector(rest / norm) : JointVector::Zero(near.size());
}

JointVector from_mid_range(const JointLimits& limits, const JointVector& joints) {
  JointVector result = JointVector::Zero(joints.size());
  for (int j = 0; j < joints.size(); ++j) {
    const double half = 0.5 * (limits.upper[j] - limits.lower[j]);
    if (std::isfinite(half) && half > 0) result[j] = (joints[j] - limits.lower[j]) / half - 1;
  }
  return result;
}

}  // namespace extperfc::arm
