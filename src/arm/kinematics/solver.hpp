#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/draws.hpp"
#include "arm/kinematics/settle.hpp"

namespace extperfc::arm {

/// One call of InverseKinematics::solve().
template <int N>
class Solver {
 public:
  Solver(const ArmChain& chain, const Pose& target, const IkOptions& options)
      : chain_(chain),
        options_(options),
        geometry_(chain.geometry()),
        task_(target, options.tolerance, geometry_),
        bounds_(bounds_of<N>(chain)),
        draws_(bounds_, options.rng_seed),
        deadline_(options.timeout_s) {}

  /// `is_beyond`: proven to be out of reach; then a few descents look for the closest approach.
  [[nodiscard]] IkResult solve(const Joints<N>& seed, bool is_beyond) {
    Descent<N> descent(geometry_, task_, bounds_);
    const int max_restarts =
        is_beyond ? std::min(kFarRestarts, options_.max_restarts) : options_.max_restarts;
    Joints<N> q = bounds_.clamp(seed);
    closest_ = q;
    for (;; ++restarts_, q = draws_.next()) {
      if (descent.run(q, deadline_)) {
        if (auto solution = offer(q, seed)) return *std::move(solution);
      } else {
        note(q, descent.cost());
      }
      const bool late = deadline_.passed();
      if (late || restarts_ == max_restarts) return tl::unexpected(failure(is_beyond, late));
    }
  }

 private:
  static constexpr int kFarRestarts = 5;
  static constexpr int kFreeDescents = 20;

  [[nodiscard]] bool accepts(const Joints<N>& q) const { return !options_.accept || options_.accept(q); }

  /// The solution at q or, where an objective is asked for and allows it, beside it; nothing when refused.
  [[nodiscard]] std::optional<IkSolution> offer(Joints<N> q, const Joints<N>& seed) {
    unwind(bounds_, seed, q);
    if (options_.objective != IkObjective::kNone) {
      const Joints<N> settled = settle(q, seed);
      if (accepts(settled)) return solution(settled);
    }
    if (accepts(q)) return solution(q);
    ++refused_;
    closest_ = q;
    return std::nullopt;
  }

  [[nodiscard]] Joints<N> settle(const Joints<N>& q, const Joints<N>& seed) const {
    const auto bounds = bounds_of<Eigen::Dynamic>(chain_);
    JointVector settled = q;
    Settle(geometry_, task_, bounds)
        .run(settled, options_.objective == IkObjective::kNearSeed ? near(seed) : mid_range(chain_),
             deadline_);
    Joints<N> out = settled;
    unwind(bounds_, seed, out);
    return out;
  }

  void note(const Joints<N>& q, double cost) {
    if (refused_ > 0 || cost >= closest_cost_) return;
    closest_cost_ = cost;
    closest_ = q;
  }

  [[nodiscard]] IkSolution solution(const Joints<N>& q) {
    here_.compute(geometry_, task_, q);
    return {q, here_.error.template head<3>().norm(), here_.error.template tail<3>().norm(), restarts_};
  }

  [[nodiscard]] IkFailure failure(bool is_beyond, bool late) {
    here_.compute(geometry_, task_, closest_);
    IkFailure failure;
    failure.proven = is_beyond;
    failure.closest = closest_;
    failure.position_error_m = here_.error.template head<3>().norm();
    failure.orientation_error_rad = here_.error.template tail<3>().norm();
    failure.restarts = restarts_;
    failure.refused = refused_;
    failure.reason = is_beyond      ? IkReason::kOutOfReach
                     : refused_ > 0 ? IkReason::kCollision
                     : late         ? IkReason::kTimeout
                                    : reason_without_limits();
    return failure;
  }

  /// True when only the joint limits prevent a solution.
  [[nodiscard]] IkReason reason_without_limits() {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Bounds<N> free = bounds_;
    free.lower.setConstant(-kNone);
    free.upper.setConstant(kNone);
    Descent<N> descent(geometry_, task_, free);
    Joints<N> q = closest_;
    for (int i = 0; i < kFreeDescents; ++i, q = draws_.next()) {
      if (descent.run(q, deadline_)) return IkReason::kLimits;
      if (deadline_.passed()) return IkReason::kTimeout;
    }
    return IkReason::kOutOfReach;
  }

  const ArmChain& chain_;
  const IkOptions& options_;
  const ChainGeometry& geometry_;
  Task task_;
  Bounds<N> bounds_;
  Draws<N> draws_;
  Deadline deadline_;
  Evaluation<N> here_;
  Joints<N> closest_;
  double closest_cost_{std::numeric_limits<double>::infinity()};
  int restarts_{0};
  int refused_{0};
};

}  // namespace extperfc::arm
