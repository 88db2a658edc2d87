#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"
#include "extperfc/navigate/local_planner.hpp"

#include "navigate/local/clearance_field.hpp"
#include "navigate/local/command_check.hpp"
#include "navigate/local/goal_approach.hpp"
#include "navigate/local/path_shift.hpp"
#include "navigate/local/path_window.hpp"
#include "navigate/local/people_cost.hpp"
#include "navigate/local/rollouts.hpp"
#include "navigate/local/shrunk_footprints.hpp"
#include "navigate/local/speed_profile.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kMaxDt_s = 1.0;
constexpr double kIdle_m_s = 0.02;    // slower commands do not move a base
constexpr double kIdle_rad_s = 0.04;  // the same
constexpr double kRest_m_s = 0.05;    // measured speed at rest: odometry is noisy
constexpr double kRest_rad_s = 0.1;   // the same
constexpr double kNoise_m_s = 0.05;   // of measured velocities
constexpr double kGapPart = 0.7;  // of the speed where the footprint nearly touches, where it seems to touch
constexpr double kDoubtAfter_s = 0.25;
constexpr std::size_t kMaxDoubt = 2;
constexpr double kDoubtLength_m = 1.2;
constexpr double kBesidePerson_m = 1.5;  // of a person, who will move: no need to squeeze through
constexpr std::size_t kMaxDoubtBeside = 1;
constexpr double kEscape_m_s = 0.12;
constexpr double kEscape_rad_s = 0.25;
constexpr int kShownCandidates = 20;

void demand_range(double value, double low, double high, const char* name) {
  demand(std::isfinite(value) && value >= low && value <= high,
         std::string(name) + " must be from " + std::to_string(low) + " to " + std::to_string(high));
}

void demand_valid(const MppiParams& params) {
  const Result<void> limits = validate(params.limits);
  demand(limits.has_value(), limits ? "" : limits.error().message);
  demand(params.base == BaseKind::kHolonomic || params.limits.max_vy_m_s == 0,
         "max_vy_m_s of a differential base must be 0");
  demand_range(params.samples, 10, 10000, "samples");
  demand_range(params.horizon_s, 0.5, 10, "horizon_s");
  demand_range(params.step_s, 0.02, 0.5, "step_s");
  demand_range(params.temperature, 1e-3, 100, "temperature");
  demand_range(params.sigma_vx_m_s, 1e-3, 5, "sigma_vx_m_s");
  demand_range(params.sigma_vy_m_s, 1e-3, 5, "sigma_vy_m_s");
  demand_range(params.sigma_wz_rad_s, 1e-3, 10, "sigma_wz_rad_s");
  demand_range(params.path_weight, 0, 1000, "path_weight");
  demand_range(params.heading_weight, 0, 1000, "heading_weight");
  demand_range(params.progress_weight, 0, 1000, "progress_weight");
  demand_range(params.obstacle_weight, 0, 1000, "obstacle_weight");
  demand_range(params.people_weight, 0, 1000, "people_weight");
  demand_range(params.smooth_weight, 0, 1000, "smooth_weight");
  demand_range(params.max_shift_m, 0, 2, "max_shift_m");
  demand_range(params.narrow_speed_m_s, 0.02, 5, "narrow_speed_m_s");
  demand_range(params.wide_clearance_m, 0.01, 1, "wide_clearance_m");
  demand_range(params.reaction_s, 0, 2, "reaction_s");
  demand_range(params.blocked_after_s, 0.1, 60, "blocked_after_s");
}

bool is_finite(const MovingObstacle& person) {
  return person.position_m.allFinite() && person.velocity_m_s.allFinite() && std::isfinite(person.radius_m) &&
         person.radius_m >= 0;
}

bool is_beside_person(const LocalState& state) {
  return std::any_of(state.people.begin(), state.people.end(), [&](const MovingObstacle& person) {
    return (person.position_m - Eigen::Vector2d(state.pose.x, state.pose.y)).norm() < kBesidePerson_m;
  });
}

bool idles(const Twist2& twist) {
  return std::hypot(twist.vx, twist.vy) < kIdle_m_s && std::abs(twist.wz) < kIdle_rad_s;
}

Twist2 mixed(const Twist2& a, const Twist2& b, double part) {
  return {a.vx + part * (b.vx - a.vx), a.vy + part * (b.vy - a.vy), a.wz + part * (b.wz - a.wz)};
}

Twist2 scaled(const Twist2& twist, double factor) {
  return {factor * twist.vx, factor * twist.vy, factor * twist.wz};
}

class MppiPlanner : public LocalPlanner {
 public:
  explicit MppiPlanner(const MppiParams& params)
      : params_(params),
        braking_{params.limits, params.reaction_s},
        approach_(params.limits, params.base),
        rollouts_(params) {}

  void set_path(const Path& path, const GoalTolerance& tolerance) override {
    window_.set(path, params_.base);
    if (!approach_.set_goal(path.poses.back(), tolerance)) shift_.clear();
  }

  void reset() override {
    window_.clear();
    shift_.clear();
    rollouts_.reset();
    approach_ = GoalApproach(params_.limits, params_.base);
    last_.reset();
    idle_s_ = 0;
    doubt_ = 0;
  }

  NavResult<LocalCommand> command(const CostGrid& costs, const Footprint& footprint, const LocalState& state,
                                  double dt_s, bool with_candidates) override;

 private:
  /// What holds for one cycle.
  struct Cycle {
    const CostGrid& costs;
    std::size_t depth;     ///< index of the footprint that is used
    std::size_t touching;  ///< index of the largest that is free at the pose
    const LocalState& state;
    Twist2 current;
    double dt_s;
    bool with_candidates;
  };

  [[nodiscard]] std::optional<NavError> refusal(const CostGrid& costs, const LocalState& state,
                                                double dt_s) const;
  [[nodiscard]] std::size_t doubt(const LocalState& state);
  [[nodiscard]] Twist2 current_velocity(const LocalState& state, double dt_s) const;
  [[nodiscard]] std::optional<Twist2> admitted(const Cycle& cycle, const Twist2& wanted) const;
  [[nodiscard]] std::optional<LocalCommand> drive_to_goal(const Cycle& cycle);
  [[nodiscard]] LocalCommand follow_path(Cycle cycle);
  [[nodiscard]] LocalCommand stop(const Cycle& cycle);
  [[nodiscard]] LocalCommand escape(const Cycle& cycle);
  [[nodiscard]] const Footprint& footprint(const Cycle& cycle) const { return footprints_.at(cycle.depth); }
  [[nodiscard]] bool find_passage(Cycle& cycle);
  /// Whether the path is blocked within the window.
  bool prepare_stations(const Cycle& cycle);
  void drop_stations_outside(const Cycle& cycle);
  void show_candidates(const Cycle& cycle, LocalCommand& out) const;
  [[nodiscard]] LocalCommand best_admitted(const Cycle& cycle);
  [[nodiscard]] NavResult<LocalCommand> finished(const Cycle& cycle, LocalCommand out);

  MppiParams params_;
  BrakingRules braking_;
  PathWindow window_;
  PathShift shift_;
  GoalApproach approach_;
  Rollouts rollouts_;
  ClearanceField field_;
  PeopleCost people_;
  ShrunkFootprints footprints_;
  Outline outline_;
  std::vector<Station> stations_;
  SpeedRules rules_;
  std::optional<Twist2> last_;  ///< command
  double idle_s_{0};            ///< without a command that moves
  std::size_t doubt_{0};        ///< index of the footprint that gaps are tried with
  Pose2 doubted_at_;
};

std::optional<NavError> MppiPlanner::refusal(const CostGrid& costs, const LocalState& state,
                                             double dt_s) const {
  const auto invalid = [](const char* what) { return NavError{NavCode::kInvalidRequest, what, {}}; };
  if (window_.empty()) return invalid("the local planner has no path: set one first");
  if (costs.empty()) return invalid("the local cost map is empty: wait for its first update");
  if (!extperfc::is_finite(state.pose) || !extperfc::is_finite(state.velocity))
    return invalid("pose or velocity of the base is not finite: check odometry and transforms");
  if (!std::all_of(state.people.begin(), state.people.end(), [](const auto& p) { return is_finite(p); }))
    return invalid("a person's position, velocity or radius is not finite: check the tracker");
  if (!(std::isfinite(dt_s) && dt_s > 0 && dt_s <= kMaxDt_s))
    return invalid("the control period must be above 0 and at most 1 s");
  if (!(state.speed_factor >= 0 && state.speed_factor <= 1))
    return invalid("the speed factor of zones must be from 0 to 1");
  return std::nullopt;
}

/// Measured velocities are late and noisy: the last command stands for them as far as it agrees with them.
Twist2 MppiPlanner::current_velocity(const LocalState& state, double dt_s) const {
  if (!last_) return state.velocity;
  const auto agreed = [&](double commanded, double measured, double acceleration) {
    const double reach = acceleration * (params_.reaction_s + dt_s) + kNoise_m_s;
    return std::clamp(commanded, measured - reach, measured + reach);
  };
  return {agreed(last_->vx, state.velocity.vx, params_.limits.acc_x_m_s2),
          agreed(last_->vy, state.velocity.vy, params_.limits.acc_y_m_s2),
          agreed(last_->wz, state.velocity.wz, params_.limits.acc_wz_rad_s2)};
}

NavResult<LocalCommand> MppiPlanner::command(const CostGrid& costs, const Footprint& footprint,
                                             const LocalState& state, double dt_s, bool with_candidates) {
  if (auto error = refusal(costs, state, dt_s)) return tl::unexpected<NavError>(std::move(*error));
  footprints_.set(footprint);
  const std::size_t touching = footprints_.depth(costs, state.pose);
  const bool deep = touching > ShrunkFootprints::kExplained;
  const std::size_t depth = std::max(touching, doubt(state));
  const Cycle cycle{costs, deep ? 0 : depth, touching, state, current_velocity(state, dt_s),
                    dt_s,  with_candidates};
  window_.locate(state.pose);
  if (deep && !approach_.settled()) return finished(cycle, escape(cycle));
  if (auto at_goal = drive_to_goal(cycle)) return finished(cycle, std::move(*at_goal));
  return finished(cycle, follow_path(cycle));
}

/// When the base has stood for a while, it goes on with a smaller footprint until it has left the place
/// behind.
std::size_t MppiPlanner::doubt(const LocalState& state) {
  const std::size_t max_doubt = is_beside_person(state) ? kMaxDoubtBeside : kMaxDoubt;
  doubt_ = std::min(doubt_, max_doubt);
  if (idle_s_ > kDoubtAfter_s * static_cast<double>(doubt_ + 1) && doubt_ < max_doubt) {
    ++doubt_;
    doubted_at_ = state.pose;
  }
  const Pose2 moved = between(doubted_at_, state.pose);
  if (std::hypot(moved.x, moved.y) > kDoubtLength_m) doubt_ = 0;
  return doubt_;
}

/// The command that `wanted` leads to within the limits, if the base can brake from it without a contact.
std::optional<Twist2> MppiPlanner::admitted(const Cycle& cycle, const Twist2& wanted) const {
  const Twist2 command =
      limited_change(wanted, cycle.current, params_.limits, cycle.dt_s, cycle.state.speed_factor);
  const CommandCheck check(cycle.costs, footprint(cycle), cycle.state, braking_);
  if (!check.free(cycle.current, command, cycle.dt_s)) return std::nullopt;
  return command;
}

std::optional<LocalCommand> MppiPlanner::drive_to_goal(const Cycle& cycle) {
  const Pose2& pose = cycle.state.pose;
  if (!approach_.near(pose, window_.remaining_m())) return std::nullopt;
  const Footprint& tried = footprints_.at(std::max(cycle.depth, kMaxDoubt));
  if (!approach_.within(pose) && contact_along(cycle.costs, tried, pose, approach_.goal()) != Contact::kFree)
    return std::nullopt;
  const Twist2 wanted = approach_.velocity(pose);
  for (const double factor : {1.0, 0.5, 0.25}) {
    if (const auto command = admitted(cycle, scaled(wanted, factor))) {
      LocalCommand out;
      out.velocity = *command;
      out.trajectory = {pose, approach_.goal()};
      out.at_goal = approach_.settled() && approach_.within(pose) && idles(out.velocity) &&
                    std::hypot(cycle.state.velocity.vx, cycle.state.velocity.vy) < kRest_m_s &&
                    std::abs(cycle.state.velocity.wz) < kRest_rad_s;
      rollouts_.reset();
      return out;
    }
  }
  return std::nullopt;
}

/// The rolling cost map ends somewhere: stations beyond are for later cycles.
void MppiPlanner::drop_stations_outside(const Cycle& cycle) {
  const double reach_m = footprint(cycle).circumscribed_radius_m() + cycle.costs.resolution_m;
  const Eigen::Vector2d low = cycle.costs.origin_m.array() + reach_m;
  const Eigen::Vector2d high =
      cycle.costs.origin_m +
      cycle.costs.resolution_m * Eigen::Vector2d(cycle.costs.width, cycle.costs.height) -
      Eigen::Vector2d(reach_m, reach_m);
  const auto outside = [&](const Station& station) {
    const Eigen::Vector2d at(cycle.state.pose.x + station.x, cycle.state.pose.y + station.y);
    return (at.array() < low.array()).any() || (at.array() > high.array()).any();
  };
  const auto end = std::find_if(stations_.begin(), stations_.end(), outside);
  const auto kept = std::max<std::ptrdiff_t>(2, end - stations_.begin());
  stations_.resize(static_cast<std::size_t>(kept));
}

/// A gap that cells and noise make too narrow is passed with a smaller footprint, slowly. False when the path
/// is blocked for these, too; the cycle then keeps its own.
bool MppiPlanner::find_passage(Cycle& cycle) {
  const Pose2& pose = cycle.state.pose;
  const double half_side_m =
      params_.limits.max_vx_m_s * params_.horizon_s + footprint(cycle).circumscribed_radius_m() + 0.5;
  field_.build(cycle.costs, {pose.x, pose.y}, half_side_m, cycle.state.people);
  const std::size_t own = cycle.depth;
  const std::size_t deepest = is_beside_person(cycle.state) ? kMaxDoubtBeside : kMaxDoubt;
  bool blocked = prepare_stations(cycle);
  while (blocked && cycle.depth < deepest) {
    ++cycle.depth;
    blocked = prepare_stations(cycle);
  }
  if (!blocked || cycle.depth == own) return !blocked;
  cycle.depth = own;
  return !prepare_stations(cycle);
}

bool MppiPlanner::prepare_stations(const Cycle& cycle) {
  const Pose2& pose = cycle.state.pose;
  const double speed = params_.limits.max_vx_m_s;
  const double length_m = speed * params_.horizon_s + 0.5 * speed * speed / params_.limits.acc_x_m_s2 + 0.4;
  outline_ = Outline(footprint(cycle));
  window_.stations(pose, length_m, stations_);
  const bool ends = window_.remaining_m() <= length_m;
  const std::size_t all = stations_.size();
  drop_stations_outside(cycle);
  const bool whole = stations_.size() == all;
  const auto blocked = shift_.apply({field_, outline_, footprint(cycle), pose},
                                    {params_.max_shift_m, params_.base == BaseKind::kHolonomic},
                                    window_.remaining_m(), stations_);
  const double narrow_m_s = (cycle.depth > 0 ? kGapPart : 1) * params_.narrow_speed_m_s;
  rules_ = {params_.limits, cycle.state.speed_factor, narrow_m_s, params_.wide_clearance_m,
            (ends && whole) || blocked.has_value()};
  fill_speed_profile(rules_, field_, outline_, stations_);
  return blocked.has_value();
}

LocalCommand MppiPlanner::follow_path(Cycle cycle) {
  const bool found = find_passage(cycle);
  const Pose2& pose = cycle.state.pose;
  const Footprint& used = footprint(cycle);
  if (!found && cycle.depth > cycle.touching) return stop(cycle);  // a wall, not a gap
  const double body_m = 0.5 * (used.inscribed_radius_m() + used.circumscribed_radius_m());
  people_.set(cycle.state.people, {pose.x, pose.y}, static_cast<float>(body_m),
              static_cast<float>(used.inscribed_radius_m()), rollouts_.steps(),
              static_cast<float>(params_.step_s));
  rollouts_.run({stations_, field_, outline_, used, people_, rules_, pose, cycle.current});
  rollouts_.update_mean();
  LocalCommand out = best_admitted(cycle);
  if (cycle.with_candidates) show_candidates(cycle, out);
  rollouts_.shift_mean(cycle.dt_s);
  return out;
}

/// The mean, the best samples, slower versions of the mean, and at last a stop.
LocalCommand MppiPlanner::best_admitted(const Cycle& cycle) {
  const double part = std::min(1.0, cycle.dt_s / params_.step_s);
  LocalCommand out;
  if (const auto command = admitted(cycle, mixed(cycle.current, rollouts_.mean(0), part))) {
    out.velocity = *command;
    rollouts_.mean_poses(cycle.state.pose, out.trajectory);
    return out;
  }
  for (const int sample : rollouts_.best()) {
    const auto command = admitted(cycle, mixed(cycle.current, rollouts_.velocity(sample, 0), part));
    if (!command || idles(*command)) continue;
    rollouts_.adopt(sample);
    out.velocity = *command;
    rollouts_.poses(sample, cycle.state.pose, out.trajectory);
    return out;
  }
  out.trajectory = {cycle.state.pose};
  for (const double factor : {0.5, 0.25}) {
    if (const auto command = admitted(cycle, scaled(rollouts_.mean(0), factor))) {
      out.velocity = *command;
      out.trajectory.push_back(advance(cycle.state.pose, out.velocity, params_.step_s));
      return out;
    }
  }
  return stop(cycle);
}

LocalCommand MppiPlanner::stop(const Cycle& cycle) {
  LocalCommand out;
  out.velocity = limited_change({}, cycle.current, params_.limits, cycle.dt_s);
  out.trajectory = {cycle.state.pose};
  rollouts_.reset();
  return out;
}

/// The footprint is in an obstacle deeper than cells and noise explain: slowly out, never deeper.
LocalCommand MppiPlanner::escape(const Cycle& cycle) {
  constexpr int kDirections = 8;
  const Pose2& pose = cycle.state.pose;
  const std::size_t now = footprints_.depth(cycle.costs, pose);
  std::size_t best = now;
  LocalCommand out;
  out.velocity = limited_change({}, cycle.current, params_.limits, cycle.dt_s);
  out.trajectory = {pose};
  for (int i = 0; i < kDirections + 2; ++i) {
    const double angle = kTwoPi * i / kDirections;
    Twist2 wanted{kEscape_m_s * std::cos(angle), kEscape_m_s * std::sin(angle), 0};
    if (i >= kDirections) wanted = {0, 0, i == kDirections ? kEscape_rad_s : -kEscape_rad_s};
    if (params_.base == BaseKind::kDifferential && std::abs(wanted.vy) > 1e-6) continue;
    const std::size_t halfway = footprints_.depth(cycle.costs, advance(pose, wanted, 0.3));
    const std::size_t end = footprints_.depth(cycle.costs, advance(pose, wanted, 0.8));
    if (halfway > now || end >= best) continue;
    best = end;
    out.velocity = limited_change(wanted, cycle.current, params_.limits, cycle.dt_s);
    out.trajectory = {pose, advance(pose, wanted, 0.8)};
  }
  rollouts_.reset();
  return out;
}

void MppiPlanner::show_candidates(const Cycle& cycle, LocalCommand& out) const {
  const int shown = std::min(kShownCandidates, rollouts_.samples());
  out.candidates.resize(static_cast<std::size_t>(shown));
  for (int i = 0; i < shown; ++i)
    rollouts_.poses(i * rollouts_.samples() / shown, cycle.state.pose,
                    out.candidates[static_cast<std::size_t>(i)]);
}

NavResult<LocalCommand> MppiPlanner::finished(const Cycle& cycle, LocalCommand out) {
  const bool waits = idles(out.velocity) && !approach_.settled() && cycle.state.speed_factor > 0;
  idle_s_ = waits ? idle_s_ + cycle.dt_s : 0;
  last_ = out.velocity;
  if (idle_s_ < params_.blocked_after_s) return out;
  last_ = Twist2{};
  const Pose2& pose = cycle.state.pose;
  return nav_fail(NavCode::kBlocked,
                  "no admissible motion leads on along the path: clear it, or plan another one", pose);
}

}  // namespace

std::unique_ptr<LocalPlanner> make_mppi_planner(const MppiParams& params) {
  demand_valid(params);
  return std::make_unique<MppiPlanner>(params);
}

}  // namespace extperfc::navigate
