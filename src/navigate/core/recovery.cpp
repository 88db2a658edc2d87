#include "extperfc/navigate/recovery.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kLookS = 0.5;          // of a motion is checked before each command
constexpr double kSettleS = 0.3;        // after a clear, until sensors have marked what they see
constexpr double kMotionTimeoutS = 15;  // of backing off or rotating
constexpr double kReachedM = 0.05;
constexpr double kMinMotionM = 0.1;  // shorter ways back do not help
constexpr double kDeepestM = 0.12;   // of an overlap that a motion may start with
constexpr double kDepthStepM = 0.02;

std::vector<RecoveryStep> ladder(NavCode cause, bool person) {
  using S = RecoveryStep;
  switch (cause) {
    case NavCode::kNoPath:
    case NavCode::kGoalBlocked:
      if (person) return {S::kYield, S::kClear, S::kWait, S::kRotate};
      [[fallthrough]];
    case NavCode::kPlanTimeout:
      return {S::kClear, S::kWait, S::kRotate};
    case NavCode::kStartBlocked:
    case NavCode::kStartOutside:
      return {S::kWait, S::kClear, S::kBackOff, S::kRotate};
    default:
      // Who is let pass is soon gone; those who walk up and down are not: there may be another passage.
      if (person) return {S::kWait, S::kYield, S::kAvoid, S::kClear, S::kBackOff, S::kRotate};
      return {S::kWait, S::kClear, S::kBackOff, S::kAvoid, S::kRotate};
  }
}

/// The pose of the trail to drive back to: the latest one that is farther away than kReachedM.
std::optional<Pose2> last_of_trail(const RecoveryView& view) {
  if (view.trail == nullptr) return std::nullopt;
  for (auto pose = view.trail->rbegin(); pose != view.trail->rend(); ++pose)
    if (distance_m(*pose, view.odom_T_base) > kReachedM) return *pose;
  return std::nullopt;
}

/// Velocity in the base's frame towards a point of the frame of `from`.
Twist2 towards(const Pose2& from, const Pose2& to, double speed_m_s) {
  const Pose2 ahead = between(from, to);
  const double away_m = std::max(std::hypot(ahead.x, ahead.y), 1e-9);
  return {speed_m_s * ahead.x / away_m, speed_m_s * ahead.y / away_m, 0};
}

/// Velocity back along the trail. Empty without a trail, and where a differential base came from beside it.
std::optional<Twist2> velocity_back(const RecoveryView& view, double speed_m_s) {
  const auto target = last_of_trail(view);
  if (!target) return std::nullopt;
  const Twist2 velocity = towards(view.odom_T_base, *target, speed_m_s);
  if (view.limits == nullptr || view.limits->max_vy_m_s > 0) return velocity;
  if (std::abs(velocity.vy) > std::abs(velocity.vx)) return std::nullopt;
  return Twist2{std::copysign(speed_m_s, velocity.vx), 0, 0};
}

bool is_safe(const RecoveryView& view, const Twist2& velocity) {
  return is_safe_motion(*view.costs, *view.footprint, view.odom_T_base,
                        advance(view.odom_T_base, velocity, kLookS));
}

}  // namespace

const char* to_string(RecoveryStep step) {
  switch (step) {
    case RecoveryStep::kWait:
      return "wait";
    case RecoveryStep::kClear:
      return "clear";
    case RecoveryStep::kBackOff:
      return "back off";
    case RecoveryStep::kRotate:
      return "rotate";
    case RecoveryStep::kAvoid:
      return "avoid";
    case RecoveryStep::kYield:
      return "yield";
  }
  return "unknown";
}

bool is_safe_motion(const CostGrid& costs, const Footprint& footprint, const Pose2& from, const Pose2& to) {
  for (double depth_m = 0; depth_m <= kDeepestM; depth_m += kDepthStepM) {
    const Footprint inner = depth_m > 0 ? footprint.padded(-depth_m) : footprint;
    if (contact(costs, inner, from) == Contact::kObstacle) continue;
    return contact_along(costs, inner, from, to) != Contact::kObstacle;
  }
  return false;
}

Recovery::Recovery(const RecoveryParams& params) {
  set_params(params);
}

void Recovery::set_params(const RecoveryParams& params) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  demand(within(params.wait_s, 0, 600) && within(params.back_off_m, 0, 5) &&
             within(params.back_off_m_s, 1e-3, 1) && within(params.rotate_rad, 0, 6.3) &&
             within(params.rotate_rad_s, 1e-3, 3) && within(params.clear_beyond_m, 0, 100) &&
             within(params.avoid_ahead_m, 0, 10) && within(params.avoid_radius_m, 1e-3, 10) &&
             within(params.avoid_person_m, 1e-3, 10) && within(params.same_place_m, 1e-3, 100) &&
             within(params.max_attempts, 1, 1000),
         "a parameter of the recovery is out of its range");
  params_ = params;
}

void Recovery::reset() {
  attempts_here_.clear();
  attempts_ = 0;
  count_ = 0;
}

bool Recovery::tried(RecoveryStep step, const Pose2& map_T_base) const {
  return std::any_of(attempts_here_.begin(), attempts_here_.end(), [&](const Attempt& attempt) {
    return attempt.step == step && distance_m(attempt.map_T_base, map_T_base) < params_.same_place_m;
  });
}

bool Recovery::possible(RecoveryStep step, const RecoveryView& view) const {
  if (step == RecoveryStep::kBackOff) {
    const auto velocity = velocity_back(view, params_.back_off_m_s);
    return params_.back_off_m > kMinMotionM && velocity && view.costs != nullptr && is_safe(view, *velocity);
  }
  if (step == RecoveryStep::kRotate)
    return params_.rotate_rad > 0 && view.costs != nullptr &&
           (is_safe(view, {0, 0, params_.rotate_rad_s}) || is_safe(view, {0, 0, -params_.rotate_rad_s}));
  if (step == RecoveryStep::kYield) return view.person_m && params_.back_off_m > 0;
  return step != RecoveryStep::kWait || params_.wait_s > 0;
}

std::optional<std::string> Recovery::begin(const NavError& cause, const RecoveryView& view) {
  if (attempts_ >= params_.max_attempts) return std::nullopt;
  for (const auto step : ladder(cause.code, view.person_m.has_value())) {
    if (tried(step, view.map_T_base) || !possible(step, view)) continue;
    step_ = step;
    began_s_ = view.now_s;
    fresh_ = true;
    began_at_ = view.odom_T_base;
    ++attempts_;
    ++count_;
    attempts_here_.push_back({step, view.map_T_base});
    if (step == RecoveryStep::kRotate) rotation_sign_ = is_safe(view, {0, 0, params_.rotate_rad_s}) ? 1 : -1;
    return reason(cause, view.map_T_base);
  }
  return std::nullopt;
}

std::string Recovery::reason(const NavError& cause, const Pose2& map_T_base) const {
  return std::string(to_string(step_)) + " at " + place_text(map_T_base) + ", because of " +
         to_string(cause.code) + ": " + cause.message;
}

void Recovery::helped() {
  if (!attempts_here_.empty()) attempts_here_.pop_back();
}

RecoveryOutput Recovery::update(const RecoveryView& view) {
  const double elapsed_s = view.now_s - began_s_;
  RecoveryOutput output;
  switch (step_) {
    case RecoveryStep::kWait:
      output.done = elapsed_s >= params_.wait_s;
      return output;
    case RecoveryStep::kClear:
      if (std::exchange(fresh_, false)) output.clear_beyond_m = params_.clear_beyond_m;
      output.done = elapsed_s >= kSettleS;
      return output;
    case RecoveryStep::kBackOff:
      return back_off(view);
    case RecoveryStep::kRotate:
      return rotate(view);
    case RecoveryStep::kAvoid:
      output.avoid = avoided(view);
      output.done = true;
      return output;
    case RecoveryStep::kYield:
      output.yield_to_m = view.person_m;
      output.done = true;
      return output;
  }
  return output;
}

RecoveryOutput Recovery::back_off(const RecoveryView& view) {
  RecoveryOutput output;
  const auto velocity = velocity_back(view, params_.back_off_m_s);
  output.done = true;
  if (!velocity || view.now_s - began_s_ > kMotionTimeoutS ||
      distance_m(view.odom_T_base, began_at_) >= params_.back_off_m)
    return output;
  if (!is_safe(view, *velocity)) return output;
  output.velocity = *velocity;
  output.done = false;
  return output;
}

RecoveryOutput Recovery::rotate(const RecoveryView& view) {
  RecoveryOutput output;
  output.done = true;
  const Twist2 velocity{0, 0, rotation_sign_ * params_.rotate_rad_s};
  // Past half a revolution the wrapped difference falls again: time ends it then.
  const double rotated_rad = std::abs(wrap_angle(view.odom_T_base.yaw - began_at_.yaw));
  const double elapsed_s = view.now_s - began_s_;
  if (rotated_rad >= std::min(params_.rotate_rad, kPi - 0.1) || elapsed_s > kMotionTimeoutS) return output;
  if (!is_safe(view, velocity)) return output;
  output.velocity = velocity;
  output.done = false;
  return output;
}

AvoidedPlace Recovery::avoided(const RecoveryView& view) const {
  if (view.person_m) return {*view.person_m, params_.avoid_person_m};
  const auto& here = view.map_T_base;
  // The robot drove the way that its trail ends with; without one it looked ahead.
  double heading_rad = here.yaw;
  if (const auto before = last_of_trail(view)) {
    const Pose2 back = between(view.odom_T_base, *before);
    heading_rad = here.yaw + std::atan2(-back.y, -back.x);
  }
  return {{here.x + params_.avoid_ahead_m * std::cos(heading_rad),
           here.y + params_.avoid_ahead_m * std::sin(heading_rad)},
          params_.avoid_radius_m};
}

}  // namespace extperfc::navigate
