#include "ros/navigate/planner_plugins.hpp"

#include <exception>
#include <utility>

#include <pluginlib/class_list_macros.hpp>

namespace extperfc::ros_navigate {

namespace {

constexpr const char* kGrid = "extperfc/GridPlanner";
constexpr const char* kMppi = "extperfc/MppiPlanner";

/// A loaded planner as a LocalPlanner that one owner holds.
class SharedLocalPlanner : public navigate::LocalPlanner {
 public:
  explicit SharedLocalPlanner(boost::shared_ptr<navigate::LocalPlanner> planner)
      : planner_(std::move(planner)) {}
  void set_path(const navigate::Path& path, const navigate::GoalTolerance& tolerance) override {
    planner_->set_path(path, tolerance);
  }
  navigate::NavResult<navigate::LocalCommand> command(const navigate::CostGrid& costs,
                                                      const navigate::Footprint& footprint,
                                                      const navigate::LocalState& state, double dt_s,
                                                      bool with_candidates) override {
    return planner_->command(costs, footprint, state, dt_s, with_candidates);
  }
  void reset() override { planner_->reset(); }

 private:
  boost::shared_ptr<navigate::LocalPlanner> planner_;
};

/// make_grid_planner() with the defaults, for who loads it by its name elsewhere.
class GridPlanner : public navigate::GlobalPlanner {
 public:
  navigate::NavResult<navigate::Path> plan(const navigate::CostGrid& costs,
                                           const navigate::Footprint& footprint,
                                           const navigate::PlanRequest& request) override {
    return planner_->plan(costs, footprint, request);
  }

 private:
  std::unique_ptr<navigate::GlobalPlanner> planner_{navigate::make_grid_planner({})};
};

/// The same of make_mppi_planner().
class MppiPlanner : public SharedLocalPlanner {
 public:
  MppiPlanner()
      : SharedLocalPlanner(boost::shared_ptr<navigate::LocalPlanner>(navigate::make_mppi_planner({}))) {}
};

}  // namespace

PlannerPlugins::PlannerPlugins()
    : global_loader_("extperfc", "extperfc::navigate::GlobalPlanner", "global_planner"),
      local_loader_("extperfc", "extperfc::navigate::LocalPlanner", "local_planner") {}

Result<std::shared_ptr<navigate::GlobalPlanner>> PlannerPlugins::global(
    const ros_params::NavigatorNodeParams& params) {
  const auto& name = params.base_global_planner;
  try {
    if (name == kGrid)
      return std::shared_ptr<navigate::GlobalPlanner>(navigate::make_grid_planner(params.global));
    auto loaded = global_loader_.createInstance(name);
    return std::shared_ptr<navigate::GlobalPlanner>(loaded.get(), [loaded](navigate::GlobalPlanner*) {});
  } catch (const std::exception& error) {
    return fail(ErrorCode::kNotFound, "base_global_planner " + name + ": " + error.what());
  }
}

Result<std::unique_ptr<navigate::LocalPlanner>> PlannerPlugins::local(
    const ros_params::NavigatorNodeParams& params) {
  const auto& name = params.base_local_planner;
  try {
    if (name == kMppi) return navigate::make_mppi_planner(params.local);
    return std::make_unique<SharedLocalPlanner>(local_loader_.createInstance(name));
  } catch (const std::exception& error) {
    return fail(ErrorCode::kNotFound, "base_local_planner " + name + ": " + error.what());
  }
}

}  // namespace extperfc::ros_navigate

PLUGINLIB_EXPORT_CLASS(extperfc::ros_navigate::GridPlanner, extperfc::navigate::GlobalPlanner)
PLUGINLIB_EXPORT_CLASS(extperfc::ros_navigate::MppiPlanner, extperfc::navigate::LocalPlanner)
