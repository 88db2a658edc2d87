#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::arm {

/// How a planning call ended; stable numbers, they cross action results.
enum class PlanCode {
  kSuccess = 0,
  kInvalidRequest = 1,      ///< sizes that do not fit, values that are not finite, no goal, a bad parameter
  kStartOutsideLimits = 2,  ///< beyond limit_repair_rad
  kStartInCollision = 3,
  kGoalOutsideLimits = 4,  ///< every goal
  kGoalInCollision = 5,    ///< every goal that respects the limits
  kTimeout = 6,            ///< no path within the time or the number of states asked
  kCancelled = 7,
};

/// Name of a code for logs, e.g. "start_in_collision".
[[nodiscard]] const char* to_string(PlanCode code);

struct PlannerParams {
  /// "rrt_connect" (our own), or one of OMPL's by planner_names().
  std::string planner{"rrt_connect"};
  /// Longest edge of the trees (Euclidean length in joint space), 0.05 to 3 rad. With more a tree grows in
  /// fewer and dearer steps.
  double range_rad{1.0};
  /// Wall time for the search, above 0 s. Simplification comes on top and is bounded by its rounds.
  double timeout_s{5.0};
  /// States in both trees together, 2 to 10,000,000; bounds the memory (some 200 bytes each).
  int max_states{200'000};
  /// Rounds of shortcutting after the first path, 0 to 10,000; 0 leaves the path as the trees found it.
  int shortcut_rounds{40};
  /// A start this far outside a joint's limits is moved onto them first; 0 to 0.2 rad.
  double limit_repair_rad{0.05};
  /// The same seed gives the same path, unless the time runs out; with a planner of OMPL only when the calls
  /// before it in the process were the same too.
  std::uint64_t seed{1};
};

struct PlanRequest {
  JointVector start;
  std::vector<JointVector> goals;   ///< reaching any one of them is success
  std::function<bool()> cancelled;  ///< asked between steps, so within milliseconds; may be empty
};

struct PlanResult {
  PlanCode code{PlanCode::kInvalidRequest};
  std::string message;                 ///< one line for people: what was wrong, and where
  std::vector<JointVector> waypoints;  ///< start first, goal last; straight segments of it are proven free
  int goal{-1};                        ///< index of the goal that was reached
  double length_rad{0};                ///< Euclidean length of the path in joint space
  double search_s{0};                  ///< wall time until the first path
  double shortcut_s{0};                ///< wall time of the simplification
  int states{0};                       ///< in the trees; 0 for a planner of OMPL
};

/// What PlannerParams::planner may be: "rrt_connect", and of OMPL "abit_star", "ait_star", "bit_star",
/// "lbkpiece", "ompl_rrt_connect", "prm_star".
[[nodiscard]] const std::vector<std::string>& planner_names();

/// Length of the polyline in joint space [rad].
[[nodiscard]] double path_length(const std::vector<JointVector>& waypoints);

/// Collision-free paths between joint configurations by two rapidly exploring random trees (Kuffner and
/// LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning", ICRA 2000) whose samples are
/// bounded by dynamic domains (Jaillet et al., "Adaptive tuning of the sampling domain for dynamic-domain
/// RRTs", IROS 2005), then shortcuts between random places of the path (Geraerts and Overmars, "Creating
/// high-quality paths for motion planning", IJRR 2007).
///
/// Every edge of the result passed CollisionChecker::motion_free(), so no state between the waypoints
/// collides, however finely the path is looked at. Limits are the model's; a continuous joint is planned
/// within [-pi, pi]. Not thread-safe: it uses the checker; the checker must outlive it.
class MotionPlanner {
 public:
  /// Throws std::invalid_argument for a parameter out of its range.
  MotionPlanner(CollisionChecker& checker, const PlannerParams& params);

  [[nodiscard]] PlanResult plan(const PlanRequest& request);

 private:
  CollisionChecker& checker_;
  PlannerParams params_;
  JointLimits limits_;
};

}  // namespace extperfc::arm
