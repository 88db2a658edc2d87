#include "arm/kinematics/settle.hpp"

#include <algorithm>
#include <cmath>

#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm {
namespace {

constexpr int kMaxSettleSteps = 50;
constexpr int kMaxHalvings = 12;
constexpr double kMinChange = 1e-7;     // [rad] or [m]
constexpr double kMinGain = 1e-9;       // of the value
constexpr double kLongestChange = 0.5;  // [rad] or [m]; the curvature of the task is left out
constexpr double kDamping = 1e-9;       // against singular Jacobians

}  // namespace

Objective near(const JointVector& seed) {
  return {seed, JointVector::Ones(seed.size())};
}

Objective mid_range(const ArmChain& chain) {
  constexpr double kEndless = 1e-6;
  Objective objective{chain.mid_range(), chain.limits().upper - chain.limits().lower};
  for (double& weight : objective.weight) weight = std::isinf(weight) ? kEndless : 4 / (weight * weight);
  return objective;
}

void Settle::run(JointVector& q, const Objective& objective, const Deadline& deadline) {
  for (int i = 0; i < kMaxSettleSteps && !deadline.passed(); ++i) {
    JointVector change = direction(q, objective);
    change *= longest_step(q, change);
    if (change.cwiseAbs().maxCoeff() < kMinChange || !advance(q, change, objective, deadline)) return;
  }
}

/// Smallest value of the objective on the linearised task, without the joints whose limits it would cross.
JointVector Settle::direction(const JointVector& q, const Objective& objective) {
  here_.compute(geometry_, task_, q);
  here_.derivative(geometry_, task_, columns_);
  JointVector wish = objective.centre - q;
  for (int round = 0;; ++round) {
    const Jacobian scaled = columns_ * objective.weight.cwiseInverse().asDiagonal();
    Matrix6 normal = scaled * columns_.transpose();
    normal.diagonal().array() += kDamping;
    const Vector6 force = solve_in_place(normal, columns_ * wish + here_.residual);
    JointVector change = wish - scaled.transpose() * force;
    if (round == q.size() || !block(q, change, wish)) return change;
  }
}

/// Takes the joints that stand next to a limit and would leave it out of the step. False when there are none.
bool Settle::block(const JointVector& q, const JointVector& change, JointVector& wish) {
  bool any = false;
  for (int i = 0; i < q.size(); ++i)
    if ((q[i] - bounds_.lower[i] < kMinChange && change[i] < 0) ||
        (bounds_.upper[i] - q[i] < kMinChange && change[i] > 0)) {
      columns_.col(i).setZero();
      wish[i] = 0;
      any = true;
    }
  return any;
}

/// Part of the change up to the first limit.
double Settle::longest_step(const JointVector& q, const JointVector& change) const {
  double part = std::min(1.0, kLongestChange / std::max(change.cwiseAbs().maxCoeff(), kMinChange));
  for (int i = 0; i < q.size(); ++i) {
    const double room = change[i] > 0 ? bounds_.upper[i] - q[i] : q[i] - bounds_.lower[i];
    if (std::abs(change[i]) * part > room) part = room / std::abs(change[i]);
  }
  return part;
}

bool Settle::advance(JointVector& q, const JointVector& change, const Objective& objective,
                     const Deadline& deadline) {
  const double value = objective.value(q);
  double part = 1;
  for (int halving = 0; halving < kMaxHalvings; ++halving, part *= 0.5) {
    JointVector next = bounds_.clamp(q + part * change);
    if (!descent_.run(next, deadline)) continue;
    if (!(objective.value(next) < (1 - kMinGain) * value)) continue;
    q = next;
    return true;
  }
  return false;
}

}  // namespace extperfc::arm
