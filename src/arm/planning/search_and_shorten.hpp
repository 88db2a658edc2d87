#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "arm/planning/request_validator.hpp"
#include "arm/planning/two_trees.hpp"

namespace extperfc::arm {

using Stop = std::function<bool()>;

/// A path that `stop` has not prevented, and the states that it took.
using SearchFunction = std::function<std::optional<Found>(const Stop& stop, int* states)>;
/// The same path or a shorter one.
using ShortenFunction =
    std::function<std::vector<JointVector>(std::vector<JointVector> waypoints, Rng& rng, const Stop& stop)>;

/// A checked request: searches within the time, shortens what was found unless cancelled, fills the result.
[[nodiscard]] PlanResult search_and_shorten(const PlanRequest& request, const Checked& checked,
                                            const PlannerParams& params, const SearchFunction& search,
                                            const ShortenFunction& shorten);

}  // namespace extperfc::arm
