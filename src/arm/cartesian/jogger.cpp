#include "extperfc/arm/jogger.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "arm/cartesian/arm_in_group.hpp"
#include "arm/cartesian/jog_motion.hpp"

namespace extperfc::arm {

namespace {

constexpr double kLongestStepS = 0.2;
constexpr std::array<double, 6> kRatios{1.0, 0.75, 0.5, 0.25, 0.1, 0.03};
constexpr double kEscapeRatio = 0.1;  // of the top speed, out of a collision
constexpr double kStandsRadS = 1e-9;

enum class Verdict { kGood, kLimit, kCollision };

const char* wrong_parameter(const JoggerParams& params, int joints) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const auto& max_velocity = params.max_velocity;
  if (max_velocity.size() > 0 &&
      (max_velocity.size() != joints || !max_velocity.allFinite() || max_velocity.minCoeff() <= 0))
    return "max_velocity: one value above 0 for each joint of the arm";
  if (!within(params.max_acceleration_rad_s2, 0.01, 100)) return "max_acceleration_rad_s2: 0.01 to 100";
  if (!within(params.command_timeout_s, 0.01, 5)) return "command_timeout_s: 0.01 to 5 s";
  if (!within(params.reaction_s, 0, 1)) return "reaction_s: 0 to 1 s";
  if (!within(params.limit_approach_s, 0.01, 5)) return "limit_approach_s: 0.01 to 5 s";
  if (!(params.singularity_stop > 0 && params.singularity_stop < params.singularity_slow &&
        std::isfinite(params.singularity_slow)))
    return "singularity_stop, singularity_slow: 0 < stop < slow";
  if (!within(params.max_lag_rad, 0.001, 1)) return "max_lag_rad: 0.001 to 1 rad";
  return nullptr;
}

}  // namespace

const char* to_string(JogHindrance hindrance) {
  switch (hindrance) {
    case JogHindrance::kNone:
      return "none";
    case JogHindrance::kJointLimit:
      return "joint_limit";
    case JogHindrance::kCollision:
      return "collision";
    case JogHindrance::kSingularity:
      return "singularity";
    case JogHindrance::kTimeout:
      return "timeout";
    case JogHindrance::kLag:
      return "lag";
    case JogHindrance::kBadInput:
      return "bad_input";
  }
  return "unknown";
}

struct Jogger::Core {
  Core(CollisionChecker& the_checker, ArmInGroup the_arm, const JoggerParams& the_params)
      : checker(&the_checker),
        arm(std::move(the_arm)),
        params(the_params),
        velocity(arm.chain(), params),
        brakes(params.max_acceleration_rad_s2, params.reaction_s) {}

  [[nodiscard]] bool fits(const JogCommand& wanted) const;
  [[nodiscard]] bool usable(const JointVector& measured, double now_s, double dt_s) const;
  [[nodiscard]] JogWish wish(double now_s);
  [[nodiscard]] Verdict judge(const JogMove& move) const;
  [[nodiscard]] bool leads_out(const JogMove& move) const;
  [[nodiscard]] std::optional<Contact> what_blocks(const JogMove& move) const;
  void advance(const JogWish& wish, double dt_s, JogStep& step);
  [[nodiscard]] bool escape(const JogWish& wish, double dt_s);

  [[nodiscard]] JointVector group(const JointVector& positions) const { return arm.put(positions, others); }

  CollisionChecker* checker;
  ArmInGroup arm;
  JoggerParams params;
  JogVelocity velocity;
  JogBrakes brakes;

  JogCommand latest;
  bool latest_fits{true};
  bool started{false};
  JogState state;      ///< as commanded last
  JointVector others;  ///< the group as measured last
};

bool Jogger::Core::fits(const JogCommand& wanted) const {
  if (!std::isfinite(wanted.stamp_s)) return false;
  if (wanted.kind == JogCommand::Kind::kJoints)
    return wanted.joint_velocity.size() == arm.joint_count() && wanted.joint_velocity.allFinite();
  return wanted.kind == JogCommand::Kind::kStop || wanted.twist.allFinite();
}

bool Jogger::Core::usable(const JointVector& measured, double now_s, double dt_s) const {
  return measured.size() == checker->model().joint_count() && measured.allFinite() && std::isfinite(now_s) &&
         dt_s > 0 && dt_s <= kLongestStepS;
}

JogWish Jogger::Core::wish(double now_s) {
  JogWish none;
  none.velocity = JointVector::Zero(arm.joint_count());
  none.scale = 0;
  if (!latest_fits) {
    none.hindrance = JogHindrance::kBadInput;
    return none;
  }
  if (latest.kind != JogCommand::Kind::kStop &&
      !(std::abs(now_s - latest.stamp_s) <= params.command_timeout_s)) {
    none.hindrance = JogHindrance::kTimeout;
    return none;
  }
  const JointVector lag = arm.take(others) - state.positions;
  if (lag.cwiseAbs().maxCoeff() > params.max_lag_rad) {
    if (state.velocities.isZero(kStandsRadS)) state.positions = arm.take(others);
    none.hindrance = JogHindrance::kLag;
    return none;
  }
  return velocity.wish(latest, state.positions);
}

Verdict Jogger::Core::judge(const JogMove& move) const {
  const auto& [lower, upper] = arm.chain().limits();
  for (const JointVector* place : {&move.next.positions, &move.stand})
    for (int j = 0; j < place->size(); ++j)
      if ((*place)[j] > std::max(upper[j], state.positions[j]) ||
          (*place)[j] < std::min(lower[j], state.positions[j]))
        return Verdict::kLimit;
  const JointVector next = group(move.next.positions);
  if (!checker->motion_free(group(state.positions), next)) return Verdict::kCollision;
  if (move.next.velocities.isZero(kStandsRadS)) return Verdict::kGood;
  return checker->motion_free(next, group(move.stand)) ? Verdict::kGood : Verdict::kCollision;
}

std::optional<Contact> Jogger::Core::what_blocks(const JogMove& move) const {
  JointVector from = group(state.positions);
  JointVector to = group(move.next.positions);
  double fraction = checker->free_fraction(from, to);
  if (fraction >= 1) {
    from = to;
    to = group(move.stand);
    fraction = checker->free_fraction(from, to);
  }
  const JointVector there = from + std::max(0.0, fraction) * (to - from);
  return checker->nearest(there);
}

/// Takes the largest fraction of the step that is proven, else brakes.
void Jogger::Core::advance(const JogWish& wish, double dt_s, JogStep& step) {
  step.hindrance = wish.hindrance;
  step.scale = wish.scale;
  if (wish.joint >= 0) step.joint = arm.chain().joint_names()[wish.joint];
  if (state.velocities.isZero(kStandsRadS) && wish.velocity.isZero(kStandsRadS)) {
    state.velocities.setZero();
    return;
  }
  Verdict first = Verdict::kGood;
  for (const double ratio : kRatios) {
    const JogMove move = brakes.move(state, wish.velocity, ratio, dt_s);
    const Verdict verdict = judge(move);
    if (verdict == Verdict::kGood) {
      state = move.next;
      return;
    }
    if (ratio < 1) continue;
    first = verdict;
    step.hindrance = verdict == Verdict::kLimit ? JogHindrance::kJointLimit : JogHindrance::kCollision;
    step.scale = 0;
    if (verdict == Verdict::kCollision) step.contact = what_blocks(move);
  }
  if (first == Verdict::kCollision && escape(wish, dt_s)) return;
  state = brakes.move(state, wish.velocity, 0.0, dt_s).next;
}

/// Out of a collision: slowly, and only where the deepest penetration gets less.
bool Jogger::Core::escape(const JogWish& wish, double dt_s) {
  if (checker->is_free(group(state.positions))) return false;
  const double excess =
      wish.velocity.cwiseAbs().cwiseQuotient(kEscapeRatio * velocity.max_velocity()).maxCoeff();
  const JogMove move = brakes.move(state, wish.velocity / std::max(1.0, excess), 1.0, dt_s);
  const auto before = checker->nearest(group(state.positions));
  const auto after = checker->nearest(group(move.next.positions));
  const auto stood = checker->nearest(group(move.stand));
  if (!before || !after || !stood) return false;
  if (after->distance_m <= before->distance_m || stood->distance_m < after->distance_m) return false;
  state = move.next;
  return true;
}

Result<Jogger> Jogger::make(CollisionChecker& checker, const ArmChain& chain, const JoggerParams& params) {
  if (const char* wrong = wrong_parameter(params, chain.joint_count()))
    return fail(ErrorCode::kInvalidArgument, std::string("JoggerParams::") + wrong);
  auto arm = ArmInGroup::make(chain, checker.model().joint_names());
  if (!arm) return tl::unexpected<Error>(arm.error());
  return Jogger(std::make_unique<Core>(checker, *std::move(arm), params));
}

Jogger::Jogger(std::unique_ptr<Core> core) : core_(std::move(core)) {}
Jogger::Jogger(Jogger&&) noexcept = default;
Jogger& Jogger::operator=(Jogger&&) noexcept = default;
Jogger::~Jogger() = default;

void Jogger::command(const JogCommand& command) {
  core_->latest_fits = core_->fits(command);
  core_->latest = command;
}

void Jogger::reset() {
  core_->started = false;
}

void Jogger::use(CollisionChecker& checker) {
  core_->checker = &checker;
}

JogStep Jogger::step(double now_s, const JointVector& measured, double dt_s) {
  Core& core = *core_;
  JogStep step;
  const bool usable = core.usable(measured, now_s, dt_s);
  if (usable) core.others = measured;
  if (!core.started && usable) {
    core.state = {core.arm.take(measured), JointVector::Zero(core.arm.joint_count())};
    core.started = true;
  }
  if (usable) {
    core.advance(core.wish(now_s), dt_s, step);
  } else {
    step.hindrance = JogHindrance::kBadInput;
    step.scale = 0;
    if (!core.started) return step;
    if (dt_s > 0 && dt_s <= kLongestStepS)
      core.state = core.brakes.move(core.state, core.state.velocities, 0.0, dt_s).next;
  }
  step.positions = core.group(core.state.positions);
  step.velocities = core.arm.put(core.state.velocities, JointVector::Zero(core.others.size()));
  step.moving = !core.state.velocities.isZero(kStandsRadS);
  return step;
}

}  // namespace extperfc::arm
