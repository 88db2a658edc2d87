#include "extperfc/navigate/exploration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace extperfc::navigate {

namespace {

constexpr std::array<double, 3> kSlackParts{0, 0.5, 1};  // of the slack of passages, one after the other

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

NavResult<std::optional<Frontier>> Exploration::next(const CostGrid& costs, const Pose2& pose,
                                                     const CanReach& can_reach) {
  query_.start = pose;
  current_.reset();
  do {
    for (const double part : kSlackParts) {
      FrontierParams params = params_;
      params.passage_slack_m *= part;
      auto list = find_frontiers(costs, footprint_, query_, params);
      if (!list) return tl::unexpected(list.error());
      current_ = best_of(*list, can_reach);
      if (current_) return current_;
    }
  } while (give_second_chance());
  return std::optional<Frontier>();
}

std::optional<Frontier> Exploration::best_of(FrontierList& list, const CanReach& can_reach) {
  frontiers_left_ = list.frontiers.size();
  unreachable_ = 0;
  for (Frontier& frontier : list.frontiers) {
    if (is_near_last_reached(frontier))
      blacklist(frontier.goal);
    else if (can_reach && !can_reach(frontier.goal))
      ++unreachable_;
    else
      return std::move(frontier);
  }
  return std::nullopt;
}

bool Exploration::is_near_last_reached(const Frontier& frontier) const {
  return last_reached_ && std::hypot(frontier.goal.x - last_reached_->x,
                                     frontier.goal.y - last_reached_->y) <= params_.blacklist_radius_m;
}

bool Exploration::give_second_chance() {
  if (failed_once_m_.empty()) return false;
  const auto failed_once = [&](const Eigen::Vector2d& goal_m) {
    return std::find(failed_once_m_.begin(), failed_once_m_.end(), goal_m) != failed_once_m_.end();
  };
  auto& blacklist_m = query_.blacklist_m;
  blacklist_m.erase(std::remove_if(blacklist_m.begin(), blacklist_m.end(), failed_once), blacklist_m.end());
  tried_again_m_.insert(tried_again_m_.end(), failed_once_m_.begin(), failed_once_m_.end());
  failed_once_m_.clear();
  return true;
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
  const Eigen::Vector2d goal_m(current_->goal.x, current_->goal.y);
  const bool again = std::any_of(tried_again_m_.begin(), tried_again_m_.end(), [&](const auto& tried_m) {
    return (tried_m - goal_m).norm() <= params_.blacklist_radius_m;
  });
  if (!again) failed_once_m_.push_back(goal_m);
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
