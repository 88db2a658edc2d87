#include "arm/kinematics/self_motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "arm/kinematics/draws.hpp"
#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm::ik {
namespace {

constexpr double kHeld = 1e-10;     // [m], [rad]
constexpr double kDamping = 1e-12;  // for the rows of free axes and at singular positions
constexpr int kNewtonSteps = 8;
constexpr double kMaxCorrection = 0.3;  // of a step; more may be a jump to another branch
constexpr double kMinStep = 1.0 / 128;  // of the step
constexpr int kBisections = 30;
constexpr std::size_t kMinRound = 3;  // neighbours of the start do not close a curve

IkTolerance tightened(const IkTolerance& held) {
  const auto tight = [](double tolerance) { return std::isinf(tolerance) ? tolerance : kHeld; };
  return {held.position_m.unaryExpr(tight), held.orientation_rad.unaryExpr(tight)};
}

}  // namespace

int SelfMotion::redundancy(int joints, const IkTolerance& held) {
  const auto axes =
      held.position_m.array().isFinite().count() + held.orientation_rad.array().isFinite().count();
  return joints - static_cast<int>(axes);
}

SelfMotion::SelfMotion(const ArmChain& chain, const JointVector& start, const IkTolerance& held, double step)
    : geometry_(chain.geometry()),
      bounds_(bounds_of<Eigen::Dynamic>(chain)),
      task_(chain.forward(start), tightened(held), geometry_),
      start_(start),
      step_(step) {}

IkBranch SelfMotion::trace(int max_steps) {
  const JointVector heading = first_heading();
  IkBranch branch;
  std::vector<JointVector> forward;
  branch.closed = walk(heading, max_steps, forward);
  if (!branch.closed) {
    (void)walk(-heading, max_steps, branch.joints);
    std::reverse(branch.joints.begin(), branch.joints.end());
  }
  branch.joints.push_back(start_);
  branch.joints.insert(branch.joints.end(), forward.begin(), forward.end());
  return branch;
}

void SelfMotion::evaluate(const JointVector& q) {
  here_.compute(geometry_, task_, q);
  here_.derivative(geometry_, task_, columns_);
}

JointVector SelfMotion::first_heading() {
  evaluate(start_);
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;
  const Eigen::SelfAdjointEigenSolver<Square> solver(columns_.transpose() * columns_);
  return solver.eigenvectors().col(0);
}

/// Null space of the Jacobian at q, on the side of the last heading.
JointVector SelfMotion::heading_at(const JointVector& q, const JointVector& last) {
  evaluate(q);
  const JointVector inside = last - min_norm_change(columns_, columns_ * last, kDamping);
  return inside.normalized();
}

bool SelfMotion::correct(JointVector& q) {
  for (int i = 0; i < kNewtonSteps; ++i) {
    evaluate(q);
    if (task_.reached(here_.error)) return true;
    q -= min_norm_change(columns_, here_.residual, kDamping);
  }
  return false;
}

/// A step of this length, back on the curve.
bool SelfMotion::advance(const JointVector& q, const JointVector& heading, double length, JointVector& next) {
  const JointVector predicted = q + length * heading;
  next = predicted;
  return correct(next) && (next - predicted).norm() <= kMaxCorrection * length;
}

/// True when the walk came back to the start, which is not repeated.
bool SelfMotion::walk(JointVector heading, int max_steps, std::vector<JointVector>& out) {
  const JointVector first = heading;
  JointVector q = start_;
  JointVector next = q;
  double length = step_;
  for (int i = 0; i < max_steps;) {
    if (!advance(q, heading, length, next)) {
      length *= 0.5;
      if (length < kMinStep * step_) return false;
      continue;
    }
    if (out.size() >= kMinRound && heading.dot(first) > 0.5 && passes_start(q, heading, length)) return true;
    if (!bounds_.contain(next)) {
      to_limit(q, heading, length, out);
      return false;
    }
    out.push_back(next);
    heading = heading_at(next, heading);
    q = next;
    length = std::min(step_, 2 * length);
    ++i;
  }
  return false;
}

bool SelfMotion::passes_start(const JointVector& q, const JointVector& heading, double length) const {
  JointVector delta = start_;
  unwind(bounds_, q, delta);
  delta -= q;
  return delta.dot(heading) > 0 && delta.dot(heading) <= length &&
         delta.norm() <= (1 + kMaxCorrection) * length;
}

/// The last position within the limits on the path of a step that leaves them.
void SelfMotion::to_limit(const JointVector& q, const JointVector& heading, double length,
                          std::vector<JointVector>& out) {
  double inside = 0;
  double outside = length;
  JointVector next = q;
  JointVector last = q;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (inside + outside);
    const bool good = advance(q, heading, middle, next) && bounds_.contain(next);
    (good ? inside : outside) = middle;
    if (good) last = next;
  }
  if (inside > 0) out.push_back(last);
}

}  // namespace extperfc::arm::ik
