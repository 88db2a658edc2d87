#include "extperfc/navigate/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/demand.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kMaxStepS = 0.5;         // longer steps of the clock are jumps
constexpr double kMinControlS = 1e-3;     // of a control cycle
constexpr double kMaxControlS = 0.2;      // the same
constexpr double kReplanS = 0.5;          // least time between plans that are urgent
constexpr double kPlannerSilentS = 20.0;  // beyond its patience: the planner does not answer
constexpr double kCoastS = 0.5;           // a replaced goal's path is driven on, while the first plan is made
constexpr double kTrailStepM = 0.1;
constexpr std::size_t kTrailPoses = 60;
constexpr double kMovedM = 0.01;  // of map -> odom: the local planner gets the path anew
constexpr double kMovedRad = 0.005;
constexpr double kDetourRatio = 1.25;  // of lengths; a path that is longer and by kDetourM is a detour
constexpr double kDetourM = 1.0;
constexpr std::size_t kMaxDetours = 8;  // that are remembered
constexpr double kYieldS = 30.0;        // until the robot goes on in any case
constexpr double kPassS = 4.0;          // a person takes, who is out of sight of where the robot yields
constexpr double kLeavesMS = 0.2;       // away from the robot: a person who has passed
constexpr double kPersonNearM = 2.5;    // a person farther away is not the cause
constexpr double kNearGoalM = 1.0;      // where the yaw counts as a part of what is left
constexpr double kMetresPerRad = 0.3;

bool all_finite(const std::vector<Pose2>& poses) {
  return std::all_of(poses.begin(), poses.end(), [](const Pose2& pose) { return is_finite(pose); });
}

/// Neither time nor another path would help.
bool is_final(NavCode code) {
  return code == NavCode::kInvalidRequest || code == NavCode::kGoalOutside || code == NavCode::kGoalUnknown;
}

bool is_of_data(NavCode code) {
  return static_cast<int>(code) >= static_cast<int>(NavCode::kNoOdometry);
}

}  // namespace

const char* to_string(NavState state) {
  switch (state) {
    case NavState::kIdle:
      return "idle";
    case NavState::kPlanning:
      return "planning";
    case NavState::kControlling:
      return "controlling";
    case NavState::kRecovering:
      return "recovering";
  }
  return "unknown";
}

Result<void> validate(const NavigatorParams& params) {
  const auto check = [](bool holds, const char* what) -> Result<void> {
    if (holds) return {};
    return fail(ErrorCode::kInvalidArgument, std::string(what) + " is out of its range");
  };
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const std::pair<bool, const char*> checks[] = {
      {within(params.planner_frequency_hz, 0, 100), "planner_frequency"},
      {within(params.planner_patience_s, 0, 3600), "planner_patience"},
      {within(params.people_patience_s, 0, 3600), "people_patience"},
      {within(params.controller_patience_s, 0, 3600), "controller_patience"},
      {within(params.oscillation_timeout_s, 0, 3600), "oscillation_timeout"},
      {within(params.oscillation_distance_m, 1e-3, 100), "oscillation_distance"},
      {within(params.data_patience_s, 0, 3600), "data_patience"},
      {within(params.blocked_ahead_m, 0, 100), "blocked_ahead"},
      {within(params.blocked_margin_m, 0, 1), "blocked_margin"},
      {within(params.deviation_m, 1e-3, 100), "path_deviation"},
      {within(params.shorter_ratio, 1e-3, 1), "shorter_ratio"},
      {within(params.detour_memory_s, 0, 3600), "detour_memory"},
      {within(params.tolerance_m, 0, 10), "default_tolerance"},
      {within(params.goal.xy_m, 1e-3, 10), "xy_goal_tolerance"},
      {within(params.goal.yaw_rad, 1e-3, 3.2), "yaw_goal_tolerance"}};
  for (const auto& [holds, what] : checks)
    if (auto checked = check(holds, what); !checked) return checked;
  return validate(params.limits);
}

Navigator::Navigator(const NavigatorParams& params, std::unique_ptr<LocalPlanner> planner)
    : planner_(std::move(planner)), recovery_(params.recovery) {
  demand(planner_ != nullptr, "a navigator needs a local planner");
  set_params(params);
}

void Navigator::set_params(const NavigatorParams& params) {
  const auto valid = validate(params);
  demand(valid.has_value(), valid ? "" : valid.error().message);
  (void)Recovery(params.recovery);  // throws for what is out of range
  params_ = params;
  recovery_.set_params(params.recovery);
  path_is_new_ = !tracker_.empty();  // with the new tolerances
}

void Navigator::set_planner(std::unique_ptr<LocalPlanner> planner) {
  demand(planner != nullptr, "a navigator needs a local planner");
  planner_ = std::move(planner);
  path_is_new_ = !tracker_.empty();
}

std::optional<Pose2> Navigator::goal() const {
  if (!task_ || goal_index_ >= task_->goals.size()) return std::nullopt;
  return task_->goals[goal_index_];
}

std::optional<NavEnd> Navigator::start(const NavTask& task) {
  std::optional<NavEnd> replaced;
  std::optional<Path> rest;
  const Twist2 command = last_command_;
  if (task_) {
    if (state_ == NavState::kControlling && !tracker_.empty()) rest = tracker_.rest_in(Pose2{});
    replaced = end_task({NavCode::kReplaced, "a newer goal came"});
  }
  task_ = task;
  goal_index_ = 0;
  missed_.clear();
  fault_since_s_.reset();
  begin_goal();
  if (rest) {
    coast_.set(*rest);
    coast_until_s_ = clock_s_ + kCoastS;
    last_command_ = command;
  }
  return replaced;
}

std::optional<NavEnd> Navigator::cancel() {
  if (!task_) return std::nullopt;
  return end_task({NavCode::kCancelled, "cancelled"});
}

void Navigator::begin_goal() {
  state_ = NavState::kPlanning;
  tracker_.clear();
  coast_.clear();
  recovery_.reset();
  progress_.reset();
  progress_.restart(clock_s_);
  avoided_.clear();
  detours_.clear();
  planner_->reset();
  yielding_.reset();
  asked_plan_.reset();
  answer_.reset();
  plan_now_ = true;
  blocked_ahead_.reset();
  recovered_ = false;
  no_plan_since_s_ = clock_s_;
  no_velocity_since_s_.reset();
  reason_.clear();
}

NavEnd Navigator::end_task(const NavError& error) {
  NavEnd end{task_->id, error, missed_};
  task_.reset();
  state_ = NavState::kIdle;
  tracker_.clear();
  coast_.clear();
  planner_->reset();
  asked_plan_.reset();
  answer_.reset();
  last_command_ = {};
  reason_.clear();
  return end;
}

void Navigator::set_plan(PlanAnswer answer) {
  if (asked_plan_ && answer.id == *asked_plan_) answer_ = std::move(answer);
}

NavigatorOutput Navigator::update(const NavigatorInput& input) {
  NavigatorOutput output;
  advance_clock(input);
  if (input.jumped) trail_.clear();
  if (!input.fault) note_trail(input.odom_T_base);
  if (task_) cycle(input, output);
  output.active = task_.has_value();
  output.state = state_;
  if (!output.active || input.fault) output.command = {};
  last_command_ = output.command;
  return output;
}

void Navigator::cycle(const NavigatorInput& input, Output& output) {
  if (task_->goals.empty() || !all_finite(task_->goals)) {
    output.end = end_task({NavCode::kInvalidRequest, "the goal is missing or not finite"});
    return;
  }
  if (input.jumped) restart_goal(output);
  if (input.map_changed) plan_now_ = map_changed_ = true;
  if (input.fault) return stand(input, output);
  if (fault_since_s_) end_fault();
  if (state_ == NavState::kRecovering) return continue_recovery(input, output);
  if (answer_) take_answer(input, output);
  if (!task_ || state_ == NavState::kRecovering) return;
  if (yielding_) yield_to_person(input);
  plan_when_due(input, output);
  if (state_ == NavState::kControlling)
    control(input, output);
  else
    wait_for_plan(input, output);
  if (task_ && state_ == NavState::kPlanning) coast(input, output);
}

/// A goal that replaces another does not stop the base: it drives on by the old path until the first plan.
/// What is in that path is the local planner's task, as it is with any other: who walks ahead is no reason to
/// stop.
void Navigator::coast(const NavigatorInput& input, Output& output) {
  if (coast_.empty()) return;
  coast_.update(input.map_T_base);
  const Pose2 odom_T_map = compose(input.odom_T_base, inverse(input.map_T_base));
  if (clock_s_ > coast_until_s_ || input.guard_stopped) return coast_.clear();
  planner_->set_path(coast_.rest_in(odom_T_map), params_.goal);
  const LocalState local{input.odom_T_base, input.velocity, input.people, input.speed_factor};
  const auto wanted = planner_->command(*input.costs, *input.footprint, local, dt_s_, false);
  if (!wanted || wanted->at_goal) return coast_.clear();
  output.command = smoothed(wanted->velocity);
}

void Navigator::advance_clock(const NavigatorInput& input) {
  const double step_s = last_now_s_ ? input.now_s - *last_now_s_ : 0;
  last_now_s_ = input.now_s;
  const double counted_s = std::clamp(std::isfinite(step_s) ? step_s : 0.0, 0.0, kMaxStepS);
  clock_s_ += counted_s;
  dt_s_ = std::clamp(counted_s, kMinControlS, kMaxControlS);
}

void Navigator::note_trail(const Pose2& odom_T_base) {
  if (state_ == NavState::kRecovering) {
    while (!trail_.empty() && distance_m(trail_.back(), odom_T_base) < 0.5 * kTrailStepM) trail_.pop_back();
    return;
  }
  if (!trail_.empty() && distance_m(trail_.back(), odom_T_base) < kTrailStepM) return;
  trail_.push_back(odom_T_base);
  if (trail_.size() > kTrailPoses) trail_.pop_front();
}

/// The robot is elsewhere than it was: what it planned and tried does not hold.
void Navigator::restart_goal(Output& output) {
  begin_goal();
  output.event = "the pose jumped: planning again";
}

void Navigator::stand(const NavigatorInput& input, Output& output) {
  if (!fault_since_s_) {
    fault_since_s_ = clock_s_;
    output.event = "stopped: " + input.fault->message;
  }
  reason_ = input.fault->message;
  if (clock_s_ - *fault_since_s_ < params_.data_patience_s) return;
  auto error = *input.fault;
  error.message +=
      "; gave up after waiting for " + std::to_string(std::lround(params_.data_patience_s)) + " s";
  output.end = end_task(error);
}

/// Data are back, and the plan is an old one. Patience goes on where it was: data that come and go shall not
/// make it endless.
void Navigator::end_fault() {
  const double stood_s = clock_s_ - *fault_since_s_;
  fault_since_s_.reset();
  reason_.clear();
  plan_now_ = true;
  progress_.leave_out(stood_s);
  if (no_velocity_since_s_) *no_velocity_since_s_ += stood_s;
  if (no_plan_since_s_) *no_plan_since_s_ += stood_s;
}

void Navigator::plan_when_due(const NavigatorInput& input, Output& output) {
  if (yielding_ && yielding_->arrived_s) return;
  const double since_s = clock_s_ - asked_s_;
  const bool periodic = state_ == NavState::kControlling && !yielding_ && params_.planner_frequency_hz > 0 &&
                        since_s * params_.planner_frequency_hz >= 1;
  const bool urgent = (plan_now_ || blocked_ahead_ || state_ == NavState::kPlanning) && !asked_plan_;
  const bool first = plan_now_ && tracker_.empty() && !asked_plan_;
  if (first || (urgent && since_s >= kReplanS) || (periodic && !asked_plan_)) ask_for_plan(input, output);
}

void Navigator::ask_for_plan(const NavigatorInput& input, Output& output) {
  plan_now_ = false;
  asked_s_ = clock_s_;
  asked_plan_ = ++next_plan_;
  PlanWish wish;
  wish.id = *asked_plan_;
  wish.request.start = input.map_T_base;
  wish.request.goal = *goal();
  wish.request.tolerance_m = params_.tolerance_m;
  if (yielding_)
    wish.yield_to_m = yielding_->to_m;
  else
    wish.avoid = avoided_now();
  if (!tracker_.empty()) wish.current = tracker_.rest_in(Pose2{});
  output.plan = std::move(wish);
}

void Navigator::take_answer(const NavigatorInput& input, Output& output) {
  const auto answer = std::move(*answer_);
  answer_.reset();
  asked_plan_.reset();
  if (yielding_ && !answer.path) return end_yielding();
  if (!answer.path) return plan_failed(answer.path.error(), answer.blocked_at, input, output);
  if (answer.path->poses.empty() || !all_finite(answer.path->poses))
    return plan_failed({NavCode::kNoPath, "the planner's path is empty or not finite"}, answer.blocked_at,
                       input, output);
  no_plan_since_s_.reset();
  if (!prefers(*answer.path, answer.blocked_at.has_value())) return;
  note_detour(*answer.path, blocked_ahead_ ? blocked_ahead_ : answer.blocked_at);
  take_path(*answer.path, output);
}

/// Paths of about the same length take turns from plan to plan; the robot stays with one.
bool Navigator::prefers(const Path& path, bool current_blocked) const {
  if (tracker_.empty() || current_blocked || blocked_ahead_ || map_changed_) return true;
  if (tracker_.deviation_m() > params_.deviation_m) return true;
  return length_m(path) < params_.shorter_ratio * tracker_.rest_m() - kTrailStepM;
}

/// Who stands in a passage and walks on a moment later made the robot turn round; it shall not turn round
/// again as soon as it does not see them any more.
void Navigator::note_detour(const Path& path, const std::optional<Pose2>& blocked_at) {
  if (tracker_.empty() || !blocked_at || params_.detour_memory_s <= 0) return;
  if (length_m(path) <= kDetourRatio * tracker_.rest_m() + kDetourM) return;
  if (detours_.size() >= kMaxDetours) detours_.pop_front();
  detours_.push_back({{{blocked_at->x, blocked_at->y}, params_.recovery.avoid_person_m},
                      clock_s_ + params_.detour_memory_s});
}

std::vector<AvoidedPlace> Navigator::avoided_now() const {
  std::vector<AvoidedPlace> places = avoided_;
  for (const Detour& detour : detours_)
    if (clock_s_ < detour.until_s) places.push_back(detour.around);
  return places;
}

void Navigator::take_path(const Path& path, Output& output) {
  coast_.clear();
  tracker_.set(path);
  path_is_new_ = true;
  map_changed_ = false;
  blocked_ahead_.reset();
  state_ = NavState::kControlling;
  if (!yielding_) progress_.path_changed(tracker_.rest_m(), clock_s_);
  output.new_path = path;
}

/// Drives on by the old path where that is free, or blocked so far away that who stands there may have gone
/// when the robot comes.
void Navigator::plan_failed(const NavError& error, const std::optional<Pose2>& blocked_at,
                            const NavigatorInput& input, Output& output) {
  coast_.clear();
  if (is_final(error.code)) return goal_done(error, output);
  const bool blocked = blocked_at && distance_m(*blocked_at, input.map_T_base) <= params_.blocked_ahead_m;
  if (!tracker_.empty() && !blocked && !map_changed_) return;
  if (!tracker_.empty()) {
    tracker_.clear();
    state_ = NavState::kPlanning;
    no_plan_since_s_ = clock_s_;
    output.event = "the path is blocked, and there is no other: " + error.message;
  }
  reason_ = error.message;
  if (!no_plan_since_s_) no_plan_since_s_ = clock_s_;
  const bool yields = error.code == NavCode::kNoPath && recovery_.may_yield(view_of(input));
  const bool waits = !input.people.empty() && !yields;
  const double patience_s =
      waits ? std::max(params_.planner_patience_s, params_.people_patience_s) : params_.planner_patience_s;
  if (clock_s_ - *no_plan_since_s_ >= patience_s) recover(error, input, output);
}

void Navigator::wait_for_plan(const NavigatorInput& input, Output& output) {
  if (!asked_plan_ || clock_s_ - asked_s_ < params_.planner_patience_s + kPlannerSilentS) return;
  asked_plan_.reset();
  recover({NavCode::kPlanTimeout, "the global planner does not answer"}, input, output);
}

/// Stands where a person can pass until nobody is near who does not walk away.
void Navigator::yield_to_person(const NavigatorInput& input) {
  const auto is_waited_for = [&](const MovingObstacle& person) {
    const Eigen::Vector2d away_m =
        person.position_m - Eigen::Vector2d(input.odom_T_base.x, input.odom_T_base.y);
    return away_m.norm() < kPersonNearM && person.velocity_m_s.dot(away_m.normalized()) < kLeavesMS;
  };
  const auto& arrived_s = yielding_->arrived_s;
  const bool passed = arrived_s && clock_s_ - *arrived_s >= kPassS &&
                      std::none_of(input.people.begin(), input.people.end(), is_waited_for);
  if (passed || clock_s_ >= yielding_->until_s) end_yielding();
}

/// Plans to the goal again; when that fails, the next recovery begins.
void Navigator::end_yielding() {
  yielding_.reset();
  asked_plan_.reset();
  answer_.reset();
  start_planning();
}

void Navigator::control(const NavigatorInput& input, Output& output) {
  if (yielding_ && yielding_->arrived_s) return;
  tracker_.update(input.map_T_base);
  const Pose2 odom_T_map = compose(input.odom_T_base, inverse(input.map_T_base));
  blocked_ahead_ = block_of(tracker_, input, odom_T_map);
  if (tracker_.deviation_m() > params_.deviation_m) plan_now_ = true;
  give_path(odom_T_map);
  LocalState local{input.odom_T_base, input.velocity, input.people, input.speed_factor};
  auto wanted = planner_->command(*input.costs, *input.footprint, local, dt_s_, input.with_candidates);
  if (!wanted) return no_velocity(wanted.error(), input, output);
  if (input.guard_stopped)
    no_velocity({NavCode::kCollisionAhead, "the collision guard stopped the robot"}, input, output);
  else
    no_velocity_since_s_.reset();
  if (state_ != NavState::kControlling) return;
  if (wanted->at_goal && yielding_) {
    yielding_->arrived_s = clock_s_;
    return;
  }
  if (wanted->at_goal) return goal_done({NavCode::kSuccess, "goal reached"}, output);
  output.command = smoothed(wanted->velocity);
  output.trajectory = std::move(wanted->trajectory);
  output.candidates = std::move(wanted->candidates);
  watch_progress(input, output);
}

/// By a smaller footprint: cells and localization are a little wrong, and the local planner knows better.
std::optional<Pose2> Navigator::block_of(const PathTracker& path, const NavigatorInput& input,
                                         const Pose2& odom_T_map) const {
  const auto inner = input.footprint->padded(-params_.blocked_margin_m);
  return path.blocked(*input.costs, inner, odom_T_map, params_.blocked_ahead_m);
}

void Navigator::give_path(const Pose2& odom_T_map) {
  const Pose2 moved = between(given_odom_T_map_, odom_T_map);
  const double away_m = distance_m(given_odom_T_map_, odom_T_map);
  if (!path_is_new_ && away_m < kMovedM && std::abs(moved.yaw) < kMovedRad) return;
  path_is_new_ = false;
  given_odom_T_map_ = odom_T_map;
  planner_->set_path(tracker_.rest_in(odom_T_map), params_.goal);
}

void Navigator::no_velocity(const NavError& error, const NavigatorInput& input, Output& output) {
  reason_ = error.message;
  if (!no_velocity_since_s_) no_velocity_since_s_ = clock_s_;
  if (clock_s_ - *no_velocity_since_s_ >= params_.controller_patience_s) recover(error, input, output);
}

void Navigator::watch_progress(const NavigatorInput& input, Output& output) {
  if (yielding_) return;
  double rest_m = tracker_.rest_m();
  if (rest_m < kNearGoalM)
    rest_m += kMetresPerRad * std::abs(wrap_angle(tracker_.path().poses.back().yaw - input.map_T_base.yaw));
  if (progress_.update(rest_m, params_.oscillation_distance_m, clock_s_)) {
    reason_.clear();
    if (std::exchange(recovered_, false)) recovery_.helped();
  }
  if (progress_.take_advance()) recovery_.advanced();
  if (params_.oscillation_timeout_s > 0 && progress_.stuck_s(clock_s_) >= params_.oscillation_timeout_s) {
    output.command = {};
    recover({NavCode::kOscillating, "the robot does not come nearer to its goal"}, input, output);
  }
}

Twist2 Navigator::smoothed(const Twist2& wanted) const {
  return limited_change(wanted, last_command_, params_.limits, dt_s_);
}

RecoveryView Navigator::view_of(const NavigatorInput& input) const {
  RecoveryView view{clock_s_,        input.map_T_base, input.odom_T_base, input.costs,
                    input.footprint, &trail_,          &params_.limits};
  double nearest_m = kPersonNearM;
  const Pose2 map_T_odom = compose(input.map_T_base, inverse(input.odom_T_base));
  for (const MovingObstacle& person : input.people) {
    const Pose2 place = compose(map_T_odom, {person.position_m.x(), person.position_m.y(), 0});
    const double away_m = distance_m(place, input.map_T_base);
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    view.person_m = {place.x, place.y};
  }
  return view;
}

void Navigator::recover(const NavError& cause, const NavigatorInput& input, Output& output) {
  yielding_.reset();
  const auto begun =
      params_.recovery_enabled ? recovery_.begin(cause, view_of(input)) : std::optional<std::string>();
  if (!begun) {
    auto error = cause;
    error.message = "gave up at " + place_text(input.map_T_base) + " after " +
                    std::to_string(recovery_.count()) + " recoveries: " + cause.message;
    if (!error.where) error.where = input.map_T_base;
    return goal_done(error, output);
  }
  state_ = NavState::kRecovering;
  asked_plan_.reset();
  answer_.reset();
  reason_ = *begun;
  output.event = "recovery: " + *begun;
}

void Navigator::continue_recovery(const NavigatorInput& input, Output& output) {
  const auto step = recovery_.update(view_of(input));
  output.command = smoothed(step.velocity);
  output.clear_beyond_m = step.clear_beyond_m;
  if (step.avoid) avoided_.push_back(*step.avoid);
  if (step.yield_to_m) yielding_ = Yielding{*step.yield_to_m, clock_s_ + kYieldS};
  if (!step.done) return;
  output.command = {};
  recovered_ = true;
  start_planning();
}

/// After a recovery.
void Navigator::start_planning() {
  state_ = NavState::kPlanning;
  tracker_.clear();
  planner_->reset();
  plan_now_ = true;
  no_plan_since_s_ = clock_s_ - params_.planner_patience_s;  // another failure leads to the next step
  no_velocity_since_s_.reset();
  progress_.restart(clock_s_);
}

void Navigator::goal_done(const NavError& error, Output& output) {
  if (error.code != NavCode::kSuccess) {
    missed_.push_back(goal_index_);
    last_failure_ = error;
  }
  const bool ends = error.code != NavCode::kSuccess && (task_->stop_at_failure || is_of_data(error.code));
  if (!ends && goal_index_ + 1 < task_->goals.size()) {
    output.event = "goal " + std::to_string(goal_index_ + 1) + ": " + error.message;
    ++goal_index_;
    return begin_goal();
  }
  output.end = end_task(missed_.empty() ? error : last_failure_);
}

}  // namespace extperfc::navigate
