#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/frontiers.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// Which frontier to drive to next, until none is left. Goals that failed are blacklisted, and so are those
/// that were reached without making their frontier known. Once nothing else is left, goals that failed get a
/// second chance: who stood there may have gone. Passages that need the slack come after all others, those
/// that need most of it last: the robot may not get out again. It ends after finitely many goals.
class Exploration {
 public:
  /// Whether the base can drive to a pose.
  using CanReach = std::function<bool(const Pose2&)>;

  /// `bounds_m`: see FrontierQuery.
  Exploration(Footprint footprint, const FrontierParams& params, std::vector<Eigen::Vector2d> bounds_m)
      : footprint_(std::move(footprint)), params_(params), query_{{}, std::move(bounds_m), {}} {}

  /// The best frontier whose goal passes `can_reach`, which is asked for the best ones first, if it is not
  /// empty. No frontier: none is left. Errors: see find_frontiers().
  [[nodiscard]] NavResult<std::optional<Frontier>> next(const CostGrid& costs, const Pose2& pose,
                                                        const CanReach& can_reach = {});
  /// The map is one that was made after the robot arrived.
  void reached();
  void failed();
  /// Whether most of the frontier that next() returned last is known by now: another goal is better.
  [[nodiscard]] bool is_outdated(const CostGrid& costs) const;

  [[nodiscard]] std::size_t frontiers_left() const { return frontiers_left_; }  ///< of the last next()
  [[nodiscard]] std::size_t unreachable() const { return unreachable_; }        ///< of these, as was answered
  [[nodiscard]] std::size_t blacklisted() const { return query_.blacklist_m.size(); }
  [[nodiscard]] std::size_t goals_reached() const { return goals_reached_; }
  [[nodiscard]] std::size_t goals_failed() const { return goals_failed_; }

 private:
  void blacklist(const Pose2& goal) { query_.blacklist_m.emplace_back(goal.x, goal.y); }
  /// Without those near the last goal, which are blacklisted.
  [[nodiscard]] std::optional<Frontier> best_of(FrontierList& list, const CanReach& can_reach);
  [[nodiscard]] bool is_near_last_reached(const Frontier& frontier) const;
  /// Whether there is a goal that failed once; it is not blacklisted any more.
  bool give_second_chance();

  Footprint footprint_;
  FrontierParams params_;
  FrontierQuery query_;
  std::optional<Frontier> current_;
  std::optional<Pose2> last_reached_;
  std::vector<Eigen::Vector2d> failed_once_m_;  ///< blacklisted
  std::vector<Eigen::Vector2d> tried_again_m_;
  std::size_t frontiers_left_{0};
  std::size_t unreachable_{0};
  std::size_t goals_reached_{0};
  std::size_t goals_failed_{0};
};

}  // namespace extperfc::navigate
