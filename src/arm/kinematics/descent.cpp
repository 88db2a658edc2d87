#include "arm/kinematics/descent.hpp"

#include <algorithm>
#include <utility>

#include "arm/kinematics/normal_equations.hpp"

namespace extperfc::arm {
namespace {

// Found by trying on random poses of a seven-joint arm; none of them matters much.
constexpr int kMaxSteps = 40;
constexpr int kStepsPerClock = 16;
constexpr int kMaxStalls = 3;
constexpr double kStall = 0.8;  // a step that leaves more of the cost than this
constexpr double kLessDamping = 0.3, kMoreDamping = 4;
constexpr double kMinDamping = 1e-9;
constexpr double kMaxFactor = 1e4;
constexpr double kLongestStep = 1.0;  // [rad] or [m] of any joint

template <int N>
void shorten(Joints<N>& change) {
  const double longest = change.cwiseAbs().maxCoeff();
  if (longest > kLongestStep) change *= kLongestStep / longest;
}

}  // namespace

template <int N>
bool Descent<N>::run(Joints<N>& q, const Deadline& deadline) {
  factor_ = 1;
  stalls_ = 0;
  here_.compute(geometry_, task_, q);
  for (int i = 0; i < kMaxSteps && stalls_ < kMaxStalls && factor_ < kMaxFactor; ++i) {
    if (task_.reached(here_.error)) return true;
    if (i % kStepsPerClock == kStepsPerClock - 1 && deadline.passed()) return false;
    if (i == 0) here_.derivative(geometry_, task_, columns_);
    step(q);
  }
  return task_.reached(here_.error);
}

template <int N>
void Descent<N>::step(Joints<N>& q) {
  const Joints<N> next = proposal(q);
  there_.compute(geometry_, task_, next);
  if (!(there_.cost < here_.cost)) {
    factor_ *= kMoreDamping;
    ++stalls_;
    return;
  }
  stalls_ = there_.cost > kStall * here_.cost ? stalls_ + 1 : 0;
  factor_ *= kLessDamping;
  q = next;
  std::swap(here_, there_);
  here_.derivative(geometry_, task_, columns_);
}

/// One damped step in the box. A first try finds the joints that meet a limit; they go there, and the others
/// make up for it.
template <int N>
Joints<N> Descent<N>::proposal(const Joints<N>& q) const {
  const double damping = factor_ * here_.cost + kMinDamping;
  Columns<N> active = movable(q);
  Joints<N> change = -min_norm_change(active, here_.residual, damping);
  shorten<N>(change);
  const Joints<N> tried = q + change;
  Joints<N> next = bounds_.clamp(tried);
  if (next == tried) return next;
  Vector6 residual = here_.residual;
  for (int i = 0; i < q.size(); ++i) {
    if (next[i] == tried[i]) {
      next[i] = q[i];
      continue;
    }
    residual += (next[i] - q[i]) * columns_.col(i);
    active.col(i).setZero();
  }
  change = -min_norm_change(active, residual, damping);
  shorten<N>(change);
  return bounds_.clamp(next + change);
}

/// The Jacobian without the joints that stand at a limit and would leave it.
template <int N>
Columns<N> Descent<N>::movable(const Joints<N>& q) const {
  const Joints<N> gradient = columns_.transpose() * here_.residual;
  Columns<N> active = columns_;
  for (int i = 0; i < q.size(); ++i)
    if ((q[i] <= bounds_.lower[i] && gradient[i] > 0) || (q[i] >= bounds_.upper[i] && gradient[i] < 0))
      active.col(i).setZero();
  return active;
}

template class Descent<6>;
template class Descent<7>;
template class Descent<Eigen::Dynamic>;

}  // namespace extperfc::arm
