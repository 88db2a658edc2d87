#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"

#include "arm/planning/rrt_connect.hpp"

namespace extperfc::arm {

/// Names of the planners of OMPL that ompl_search() knows.
[[nodiscard]] const std::vector<std::string>& ompl_planners();

/// BIT*, ABIT*, AIT* and PRM*: they make their own path shorter for as long as they are let.
[[nodiscard]] bool improves(const std::string& ompl_planner);

/// A path by one of OMPL's planners, whose edges are proven free like ours. With `improve` those that
/// improves() names go on until `stop`, and the last path is the shortest; else all end with the first one.
/// The start and all goals must be free and within the limits; `planner` must be one of ompl_planners().
/// OMPL's random numbers are seeded once per process, so a path repeats only when the calls before it do.
[[nodiscard]] std::optional<Found> ompl_search(CollisionChecker& checker, const JointLimits& limits,
                                               const PlannerParams& params, const JointVector& start,
                                               const std::vector<JointVector>& goals, bool improve,
                                               const std::function<bool()>& stop);

}  // namespace extperfc::arm
