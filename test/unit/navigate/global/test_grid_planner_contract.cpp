#include "test/unit/navigate/planner_contract.hpp"

namespace extperfc::navigate::contract {

namespace {

PlannerCase grid_planner(const std::string& name, double cost_factor, BaseKind base) {
  return {name,
          [=] {
            GridPlannerParams params;
            params.cost_factor = cost_factor;
            params.base = base;
            return make_grid_planner(params);
          },
          // Where it touches, a differential base follows a lattice of 16 directions.
          base == BaseKind::kDifferential ? 1.25 : 1.02,
          base == BaseKind::kDifferential ? 2 * kCell_m : kCell_m,
          base == BaseKind::kDifferential
              ? "a differential base smaller than a cell does not find every passage of one cell"
              : nullptr};
}

}  // namespace

INSTANTIATE_TEST_SUITE_P(GridPlanner, PlannerContract,
                         testing::Values(grid_planner("Holonomic", 3, BaseKind::kHolonomic),
                                         grid_planner("Shortest", 0, BaseKind::kHolonomic),
                                         grid_planner("Differential", 3, BaseKind::kDifferential)),
                         case_name);

}  // namespace extperfc::navigate::contract
