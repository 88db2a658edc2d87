#pragma once

#include <memory>
#include <string>

#include <pluginlib/class_loader.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/global_planner.hpp"
#include "extperfc/navigate/local_planner.hpp"

#include "ros/params/navigator_params.hpp"

namespace extperfc::ros_navigate {

/// Planners by the names of their plugins. extperfc/GridPlanner and extperfc/MppiPlanner get the navigator's
/// parameters; a user's own class is constructed without arguments and reads what it needs itself. Outlives
/// the planners that it made.
class PlannerPlugins {
 public:
  PlannerPlugins();

  /// Errors: no such plugin, a library that cannot be loaded, parameters that the planner refuses.
  [[nodiscard]] Result<std::shared_ptr<navigate::GlobalPlanner>> global(
      const ros_params::NavigatorNodeParams& params);
  [[nodiscard]] Result<std::unique_ptr<navigate::LocalPlanner>> local(
      const ros_params::NavigatorNodeParams& params);

 private:
  pluginlib::ClassLoader<navigate::GlobalPlanner> global_loader_;
  pluginlib::ClassLoader<navigate::LocalPlanner> local_loader_;
};

}  // namespace extperfc::ros_navigate
