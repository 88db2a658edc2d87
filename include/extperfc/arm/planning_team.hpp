#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_planner.hpp"

namespace extperfc::arm {

struct TeamMember {
  std::string planner{"rrt_connect"};  ///< one of planner_names()
  std::uint64_t seed{1};
};

/// What a path is worth: less is better, e.g. its length or the duration of its trajectory. Called from
/// several threads at once.
using PathCost = std::function<double(const std::vector<JointVector>&)>;

struct PlanningTeamParams {
  /// 1 to 16 of them.
  std::vector<TeamMember> members{{"rrt_connect", 1}, {"rrt_connect", 2}};
  /// That plan, 1 to 8; the calling thread only waits. Where a member is a planner of OMPL, every such member
  /// needs a thread, and the others one more.
  int threads{2};
  /// For all members; `planner`, `seed` and `timeout_s` do not count.
  PlannerParams planner;
  PathCost cost;  ///< empty: path_length()
};

/// How much is spent on one request.
struct TeamEffort {
  double timeout_s{
      5.0};  ///< wall time of the whole call, above 0 s; it returns some milliseconds later at most
  /// Go on after the first path: the members start over with new seeds, and the path of lowest cost wins.
  /// bit_star, abit_star, ait_star and prm_star do not start over but shorten their own path until the time
  /// is up.
  bool improve{false};
  /// With `improve`: maximum number of planned paths, 1 to 1,000,000; with 1,000,000 the time decides.
  int max_attempts{1'000'000};
};

struct TeamResult {
  PlanResult plan;
  int member{-1};   ///< that found the path; -1: the straight one
  double cost{0};   ///< of the path
  int attempts{0};  ///< with `improve`: paths looked for and ended
  int found{0};     ///< with `improve`: of these with a path
};

/// Several planners on one problem, in threads.
///
/// Without `improve` the first solution stops the others, and "first" is counted in work, not in time: our
/// own planners search in rounds of samples that double, and the path of the lowest (round, index of the
/// member) wins; members that could still come before it finish their round. So the same members give the
/// same path with any number of threads, on any machine, unless the time runs out.
///
/// With `improve` the attempts are numbered; attempt k is of member k mod n with a seed of its own, and the
/// lowest cost wins, the lowest number where two are equal. So with max_attempts reached before the time is
/// up the result is the same with any number of threads too; when the time ends it, it is not.
///
/// Neither holds with a planner of OMPL among the members: OMPL draws the seeds of its generators from one
/// counter of the process (behind a lock, so threads are safe), and such a member wins as soon as it is done.
///
/// Every call plans with fresh clones of the checker. PlanRequest::cancelled is asked by the calling thread
/// alone, every 2 ms; all threads have ended when plan() returns. One call at a time.
class PlanningTeam {
 public:
  /// The checker must outlive it. Throws std::invalid_argument for a parameter out of its range.
  PlanningTeam(CollisionChecker& checker, const PlanningTeamParams& params);

  /// Throws std::invalid_argument for an effort out of its range.
  [[nodiscard]] TeamResult plan(const PlanRequest& request, const TeamEffort& effort = {});

 private:
  CollisionChecker& checker_;
  PlanningTeamParams params_;
  JointLimits limits_;
};

}  // namespace extperfc::arm
