#include "arm/planning/search_and_shorten.hpp"

#include <utility>

#include "arm/planning/termination.hpp"

namespace extperfc::arm {

PlanResult search_and_shorten(const PlanRequest& request, const Checked& checked, const PlannerParams& params,
                              const SearchFunction& search, const ShortenFunction& shorten) {
  Termination termination(request, params.timeout_s);
  PlanResult result;
  auto found = search([&] { return termination.over(); }, &result.states);
  result.search_s = termination.seconds();
  if (!found) {
    result.code = termination.code();
    result.message = termination.message(params.max_states);
    return result;
  }
  Rng rng(params.seed);
  result.waypoints = shorten(std::move(found->waypoints), rng, [&] { return termination.cancelled(); });
  result.shortcut_s = termination.seconds() - result.search_s;
  if (termination.code() == PlanCode::kCancelled) return failed(PlanCode::kCancelled, "cancelled");
  result.code = PlanCode::kSuccess;
  result.goal = checked.goal_indices[found->goal];
  result.length_rad = path_length(result.waypoints);
  return result;
}

}  // namespace extperfc::arm
