#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/global_planner.hpp"
#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/navigate/path_tracker.hpp"
#include "extperfc/navigate/progress_monitor.hpp"
#include "extperfc/navigate/recovery.hpp"
#include "extperfc/navigate/velocity.hpp"

namespace extperfc::navigate {

struct NavigatorParams {
  double planner_frequency_hz{1.0};   ///< plans while driving; 0: only when needed, [0, 100]
  double planner_patience_s{5.0};     ///< without a plan, until a recovery begins, [0, 3600]
  double people_patience_s{20.0};     ///< in place of a shorter planner_patience_s while people are near: who
                                      ///< stands at the goal may walk on, [0, 3600]
  double controller_patience_s{3.0};  ///< without a velocity, until a recovery begins, [0, 3600]
  double oscillation_timeout_s{10.0};  ///< without progress, until a recovery begins; 0: never, (0, 3600]
  double oscillation_distance_m{0.5};  ///< that counts as progress, (0, 100]
  double data_patience_s{30.0};        ///< without sensor data, until the goal is given up, [0, 3600]
  double blocked_ahead_m{2.5};    ///< a path that is blocked so near is planned again, and left when there is
                                  ///< no other; one that is blocked farther away is driven on, [0, 100]
  double blocked_margin_m{0.05};  ///< by which the footprint is smaller for that, [0, 1]
  double deviation_m{0.6};        ///< from the path, at which it is planned again, (0, 100]
  double shorter_ratio{0.9};      ///< of lengths, at which another path is preferred, (0, 1]
  double detour_memory_s{60.0};   ///< where a much longer path was taken is avoided, [0, 3600]
  double tolerance_m{0.0};        ///< a goal that is blocked may be moved this far, [0, 10]
  bool recovery_enabled{true};
  GoalTolerance goal;
  VelocityLimits limits;
  RecoveryParams recovery;
};

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const NavigatorParams& params);

/// Goals that are driven to in turn.
struct NavTask {
  std::uint64_t id{0};
  std::vector<Pose2> goals;     ///< in the frame map, 1 or more
  bool stop_at_failure{false};  ///< false: a goal that fails is left out
};

/// How a task ended.
struct NavEnd {
  std::uint64_t task{0};
  NavError error;  ///< kSuccess, or why it failed; with the last error when goals were missed
  std::vector<std::size_t> missed;  ///< goals of the task that were not reached
};

/// A request for a plan, which a worker makes while the robot drives on.
struct PlanWish {
  std::uint64_t id{0};
  PlanRequest request;                ///< in the frame map
  std::vector<AvoidedPlace> avoid{};  ///< to be given high costs
  Path current{};                     ///< the path that is followed now, from the robot on; perhaps empty
  /// In place of the request's goal: to a place where this person can pass, in the frame map.
  std::optional<Eigen::Vector2d> yield_to_m{};
};

struct PlanAnswer {
  std::uint64_t id{0};                ///< of the wish
  NavResult<Path> path{};             ///< in the frame map
  std::optional<Pose2> blocked_at{};  ///< where the wish's current path first touches an obstacle
};

/// What the navigator knows in a cycle. Pointers are valid during the call.
struct NavigatorInput {
  double now_s{0};                  ///< of any clock; jumps of it do no harm
  std::optional<NavError> fault{};  ///< data are missing or old: the robot must stand
  Pose2 map_T_base;
  Pose2 odom_T_base;
  Twist2 velocity;                       ///< in the base's frame
  const CostGrid* costs{nullptr};        ///< local, in the frame odom; null only with a fault
  const Footprint* footprint{nullptr};   ///< with padding; null only with a fault
  std::vector<MovingObstacle> people{};  ///< in odom
  double speed_factor{1};                ///< of speed zones
  bool map_changed{false};               ///< since the last cycle
  bool jumped{false};                    ///< the pose in odom or in the map, since the last cycle
  bool guard_stopped{false};             ///< the collision guard let no motion pass in the last cycle
  bool with_candidates{false};           ///< for display
};

enum class NavState { kIdle, kPlanning, kControlling, kRecovering };

/// "idle", "planning", "controlling", "recovering".
[[nodiscard]] const char* to_string(NavState state);

struct NavigatorOutput {
  Twist2 command;  ///< within the limits; zero while idle, planning, or with a fault
  NavState state{NavState::kIdle};
  bool active{false};                      ///< a task is under way: the command is to be sent
  std::optional<PlanWish> plan{};          ///< to be made; one that is under way may be dropped
  std::optional<double> clear_beyond_m{};  ///< clear the cost maps now
  std::optional<NavEnd> end{};             ///< of the task
  std::string event{};                     ///< one line for a log, when there is news
  std::vector<Pose2> trajectory{};         ///< in odom, of the local planner
  std::vector<std::vector<Pose2>> candidates{};
  std::optional<Path> new_path{};  ///< in the frame map
};

/// move_base's state machine: plans (asked for, never waited for), controls, recovers, and ends every task
/// with a code and a message. Time, data and plans come from outside; nothing blocks. One thread at a time.
///
/// Every task ends: patience is counted in time that runs only forwards (jumps of the clock do not count),
/// recoveries are never repeated at a place and their number is limited.
class Navigator {
 public:
  /// Throws std::invalid_argument unless validate(params). `planner` must not be null.
  Navigator(const NavigatorParams& params, std::unique_ptr<LocalPlanner> planner);

  /// Begins a task. The end (kReplaced) of the one before, if it was under way. A task without goals or with
  /// one that is not finite ends at the next update with kInvalidRequest.
  std::optional<NavEnd> start(const NavTask& task);
  /// Ends the task with kCancelled, if there is one.
  std::optional<NavEnd> cancel();
  /// An answer to a wish; others than the latest are ignored.
  void set_plan(PlanAnswer answer);
  [[nodiscard]] NavigatorOutput update(const NavigatorInput& input);

  /// Takes new parameters while it runs. Throws as the constructor.
  void set_params(const NavigatorParams& params);
  void set_planner(std::unique_ptr<LocalPlanner> planner);

  [[nodiscard]] bool active() const { return task_.has_value(); }
  [[nodiscard]] NavState state() const { return state_; }
  [[nodiscard]] std::optional<Pose2> goal() const;
  [[nodiscard]] std::size_t goal_index() const { return goal_index_; }
  [[nodiscard]] double distance_left_m() const { return tracker_.rest_m(); }
  [[nodiscard]] int recoveries() const { return recovery_.count(); }
  /// Why the robot stands though a task is under way; empty while it drives.
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  using Output = NavigatorOutput;

  void begin_goal();
  void restart_goal(Output& output);
  void cycle(const NavigatorInput& input, Output& output);
  void advance_clock(const NavigatorInput& input);
  void note_trail(const Pose2& odom_T_base);
  void stand(const NavigatorInput& input, Output& output);
  void end_fault();
  void plan_when_due(const NavigatorInput& input, Output& output);
  void ask_for_plan(const NavigatorInput& input, Output& output);
  void take_answer(const NavigatorInput& input, Output& output);
  [[nodiscard]] bool prefers(const Path& path, bool current_blocked) const;
  void note_detour(const Path& path, const std::optional<Pose2>& blocked_at);
  [[nodiscard]] std::vector<AvoidedPlace> avoided_now() const;
  void take_path(const Path& path, Output& output);
  void plan_failed(const NavError& error, const std::optional<Pose2>& blocked_at, const NavigatorInput& input,
                   Output& output);
  void wait_for_plan(const NavigatorInput& input, Output& output);
  void yield_to_person(const NavigatorInput& input);
  void end_yielding();
  void coast(const NavigatorInput& input, NavigatorOutput& output);
  void control(const NavigatorInput& input, Output& output);
  [[nodiscard]] std::optional<Pose2> block_of(const PathTracker& path, const NavigatorInput& input,
                                              const Pose2& odom_T_map) const;
  void give_path(const Pose2& odom_T_map);
  void no_velocity(const NavError& error, const NavigatorInput& input, Output& output);
  void watch_progress(const NavigatorInput& input, Output& output);
  [[nodiscard]] Twist2 smoothed(const Twist2& wanted) const;
  [[nodiscard]] RecoveryView view_of(const NavigatorInput& input) const;
  void recover(const NavError& cause, const NavigatorInput& input, Output& output);
  void continue_recovery(const NavigatorInput& input, Output& output);
  void start_planning();
  void goal_done(const NavError& error, Output& output);
  [[nodiscard]] NavEnd end_task(const NavError& error);

  NavigatorParams params_;
  std::unique_ptr<LocalPlanner> planner_;
  NavState state_{NavState::kIdle};
  std::optional<NavTask> task_;
  std::size_t goal_index_{0};
  std::vector<std::size_t> missed_;
  NavError last_failure_{NavCode::kSuccess, ""};

  double clock_s_{0};  ///< sum of short steps of the given time
  double dt_s_{0};
  std::optional<double> last_now_s_;

  PathTracker tracker_;
  PathTracker coast_;  ///< rest of the path to a goal that was replaced, until the new goal's first plan
  double coast_until_s_{0};
  bool path_is_new_{false};  ///< the local planner does not have it yet
  Pose2 given_odom_T_map_;   ///< with which it has it
  Recovery recovery_;
  ProgressMonitor progress_;
  std::vector<AvoidedPlace> avoided_;
  struct Detour {
    AvoidedPlace around;
    double until_s;
  };
  std::deque<Detour> detours_;
  std::deque<Pose2> trail_;  ///< in odom
  Twist2 last_command_;
  std::string reason_;

  /// To a person who cannot pass the robot where it is.
  struct Yielding {
    Eigen::Vector2d to_m;  ///< where the person was, in the frame map
    double until_s;
    std::optional<double> arrived_s{};
  };
  std::optional<Yielding> yielding_;

  std::uint64_t next_plan_{0};
  std::optional<std::uint64_t> asked_plan_;  ///< under way
  std::optional<PlanAnswer> answer_;
  double asked_s_{0};
  bool plan_now_{false};
  std::optional<Pose2> blocked_ahead_;  ///< where the path is blocked near the robot, in the frame map
  bool map_changed_{false};             ///< no plan since
  bool recovered_{false};               ///< and not come nearer since
  std::optional<double> no_plan_since_s_;
  std::optional<double> no_velocity_since_s_;
  std::optional<double> fault_since_s_;
};

}  // namespace extperfc::navigate
