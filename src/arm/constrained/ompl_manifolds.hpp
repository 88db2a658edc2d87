#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/constrained_planner.hpp"

#include "arm/constrained/cbirrt.hpp"

namespace extperfc::arm {

/// Names of the planners of OMPL that ompl_search() knows.
[[nodiscard]] const std::vector<std::string>& ompl_manifold_planners();

/// A path by OMPL's RRTConnect in one of its spaces of constrained states, refined and proven as ours. What
/// cannot be proven is thrown away and searched for again until `stop` says so. The start and all goals must
/// be free, within the limits and on the manifold. OMPL's random numbers are seeded once per process.
[[nodiscard]] std::optional<Found> ompl_search(CollisionChecker& checker, Manifold& manifold,
                                               const ConstrainedPlannerParams& params,
                                               const JointVector& start, const States& goals,
                                               const std::function<bool()>& stop);

}  // namespace extperfc::arm
