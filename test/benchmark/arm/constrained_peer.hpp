#pragma once

#include "test/benchmark/arm/constrained_problems.hpp"
#include "test/benchmark/arm/peer_ompl.hpp"

namespace extperfc::benchmark {

enum class PeerSpace { kAtlas, kProjected };

/// OMPL's RRTConnect in one of its spaces of constrained states, everything at its defaults: range, step
/// along the manifold, tolerance of projections (1e-4); then OMPL's simplification (1 s at most) and its
/// dense states. States are asked of `checker`, the constraint is the problem's with its analytic Jacobian.
/// `seconds` of the result are CPU time.
[[nodiscard]] PeerPlan plan_with_ompl(const LevelProblem& problem, arm::CollisionChecker& checker,
                                      PeerSpace space, double timeout_s);

}  // namespace extperfc::benchmark
