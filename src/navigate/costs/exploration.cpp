#include "extperfc/navigate/exploration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace extperfc::navigate {

namespace {

bool is_known(const CostGrid& costs, const Eigen::Vector2d& point_m) {
  const auto cell = costs.cell_of(point_m);
  return !cell || costs.at(*cell) != kUnknownCost;
}

/// Whether all cells beside a point's cell are known.
bool is_inside(const CostGrid& costs, const Eigen::Vector2d& point_m) {
  const double step_m = costs.resolution_m;
  return is_known(costs, point_m + Eigen::Vector2d(step_m, 0)) &&
         is_known(costs, point_m - Eigen::Vector2d(step_m, 0)) &&
         is_known(costs, point_m + Eigen::Vector2d(0, step_m)) &&
         is_known(costs, point_m - Eigen::Vector2d(0, step_m));
}

}  // namespace

NavResult<std::optional<Frontier>> Exploration::next(const CostGrid& costs, const Pose2& pose) {
  query_.start = pose;
  current_.reset();
  while (true) {
    auto list = find_frontiers(costs, footprint_, query_, params_);
    if (!list) return tl::unexpected(list.error());
    frontiers_left_ = list->frontiers.size();
    if (list->frontiers.empty()) return std::optional<Frontier>();
    const Pose2& goal = list->frontiers.front().goal;
    const bool again = last_reached_ && std::hypot(goal.x - last_reached_->x, goal.y - last_reached_->y) <=
                                            params_.blacklist_radius_m;
    if (!again) {
      current_ = std::move(list->frontiers.front());
      return current_;
    }
    blacklist(*last_reached_);
    last_reached_.reset();
  }
}

void Exploration::reached() {
  if (!current_) return;
  ++goals_reached_;
  last_reached_ = current_->goal;
  current_.reset();
}

void Exploration::failed() {
  if (!current_) return;
  ++goals_failed_;
  blacklist(current_->goal);
  current_.reset();
}

bool Exploration::is_outdated(const CostGrid& costs) const {
  if (!current_) return false;
  const auto known = std::count_if(current_->points_m.begin(), current_->points_m.end(),
                                   [&](const auto& point_m) { return is_inside(costs, point_m); });
  constexpr double kMaxKnown = 0.7;
  return static_cast<double>(known) > kMaxKnown * static_cast<double>(current_->points_m.size());
}

}  // namespace extperfc::navigate
