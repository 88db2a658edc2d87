#include "extperfc/arm/motion_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <utility>

#include "extperfc/arm/cartesian_path.hpp"
#include "extperfc/arm/constrained_planner.hpp"
#include "extperfc/arm/planning_team.hpp"
#include "extperfc/base/demand.hpp"
#include "extperfc/base/stopwatch.hpp"

#include "arm/motion/goal_finder.hpp"
#include "arm/motion/proven_trajectory.hpp"
#include "arm/motion/second_attempt.hpp"

namespace extperfc::arm {

namespace {

MotionOutcome outcome_of(ArmCode code, std::string message) {
  MotionOutcome outcome;
  outcome.code = code;
  outcome.message = std::move(message);
  return outcome;
}

constexpr double kPathStart = 0.05;        // of the robot from a path's first state [rad]
constexpr double kFineCorner = 5e-5;       // where waypoints are dense [rad]
constexpr double kConstraintError = 1e-4;  // of the motion as the robot makes it [m] or [rad]

ArmCode code_of(CartesianEnd end) {
  switch (end) {
    case CartesianEnd::kComplete:
      return ArmCode::kSuccess;
    case CartesianEnd::kInvalidRequest:
      return ArmCode::kInvalidRequest;
    case CartesianEnd::kStartOutsideLimits:
      return ArmCode::kStartOutsideLimits;
    case CartesianEnd::kStartInCollision:
      return ArmCode::kStartInCollision;
    case CartesianEnd::kLimit:
    case CartesianEnd::kCollision:
    case CartesianEnd::kSingularity:
    case CartesianEnd::kOutOfReach:
      return ArmCode::kPathIncomplete;
    case CartesianEnd::kCancelled:
      return ArmCode::kCancelled;
    case CartesianEnd::kTimeout:
      return ArmCode::kPlanningTimeout;
  }
  return ArmCode::kInternal;
}

std::optional<std::string> problem(const MotionRequest& request) {
  const auto scale = [](double value) { return value > 0.0 && value <= 1.0; };
  if (!(request.planning_time_s > 0.0)) return "the planning time must be above 0 s";
  if (!scale(request.velocity_scale)) return "the velocity scale must be above 0 and at most 1";
  if (!scale(request.acceleration_scale)) return "the acceleration scale must be above 0 and at most 1";
  if (!scale(request.minimum_fraction)) return "the minimum fraction must be above 0 and at most 1";
  if (request.kind == MotionKind::kLinear && !request.constraints.empty())
    return "a straight motion takes no constraints";
  for (const auto& [name, value] : request.start)
    if (!std::isfinite(value)) return "the position of " + name + " is not finite";
  return std::nullopt;
}

}  // namespace

/// The robot's collision model for a group, and where its other joints stand in it.
struct MotionPipeline::Models {
  struct Entry {
    JointPositions others;
    CollisionModel model;
  };
  std::map<std::pair<std::string, bool>, Entry> entries;  ///< by group and padding

  /// A joint may have moved by this without a new model: it moves no point by 0.3 mm.
  static constexpr double kStill = 1e-4;

  static bool same(const JointPositions& a, const JointPositions& b) {
    if (a.size() != b.size()) return false;
    for (auto i = a.begin(), k = b.begin(); i != a.end(); ++i, ++k)
      if (i->first != k->first || std::abs(i->second - k->second) > kStill) return false;
    return true;
  }
};

MotionPipeline::MotionPipeline(RobotArms arms, const MotionPipelineParams& params)
    : arms_(std::move(arms)), params_(params), models_(std::make_unique<Models>()) {
  demand(params.padding_m >= 0.0015 && params.padding_m <= 0.05,
         "MotionPipelineParams::padding_m: 0.0015 to 0.05 m");
  demand(params.corner_deviation_rad >= 0.0 && params.corner_deviation_rad <= 0.5,
         "MotionPipelineParams::corner_deviation_rad: 0 to 0.5 rad");
  demand(params.goal_samples >= 1 && params.goal_samples <= 100,
         "MotionPipelineParams::goal_samples: 1 to 100");
  demand(params.threads >= 1 && params.threads <= 8, "MotionPipelineParams::threads: 1 to 8");
  demand(params.goal_time_s > 0.0, "MotionPipelineParams::goal_time_s: above 0 s");
}

MotionPipeline::~MotionPipeline() = default;
MotionPipeline::MotionPipeline(MotionPipeline&&) noexcept = default;

Result<CollisionChecker> MotionPipeline::checker(const std::string& group, const JointPositions& positions,
                                                 const CollisionWorld& world, bool padded) {
  const auto found = arms_.group(group);
  if (!found) return tl::unexpected(found.error());
  CollisionModelParams params;
  params.joints = (*found)->joints;
  params.allowed = allowed_pairs(arms_.srdf());
  params.world_padding_m = params.self_padding_m = padded ? params_.padding_m : 0.0;
  for (const auto& joint : arms_.robot().joints()) {
    const auto known = positions.find(joint.name);
    if (known != positions.end() && joint.type != JointType::kFixed &&
        std::find(params.joints.begin(), params.joints.end(), joint.name) == params.joints.end())
      params.fixed_positions.insert(*known);
  }
  auto entry = models_->entries.find({group, padded});
  if (entry == models_->entries.end() || !Models::same(entry->second.others, params.fixed_positions)) {
    auto model = CollisionModel::make(arms_.robot(), params);
    if (!model) return tl::unexpected(model.error());
    if (entry != models_->entries.end()) models_->entries.erase(entry);
    entry = models_->entries.insert({{group, padded}, {params.fixed_positions, std::move(*model)}}).first;
  }
  return CollisionChecker::make(entry->second.model, world);
}

namespace {

/// Processes one request.
class Run {
 public:
  Run(MotionPipeline& pipeline, const MotionRequest& request, const CollisionWorld& world)
      : pipeline_(pipeline), request_(request), world_(world) {
    params_ = pipeline.params().planner;
    if (request.seed) params_.seed = *request.seed;
    if (!request.planner.empty()) params_.planner = request.planner;
  }

  MotionOutcome run() {
    if (auto wrong = prepare(true)) return *wrong;
    if (!request_.path.empty()) return follow_path();
    if (request_.kind == MotionKind::kLinear) return plan_linear();
    auto goals = search_goals();
    // What the padding alone forbids is tried without it: a hand beside the object that it lets go, for one.
    if (near_something(goals)) {
      if (auto made = make_checker(false); !made)
        return outcome_of(ArmCode::kInvalidRequest, made.error().message);
      goals = search_goals();
    }
    if (!goals) return finish(outcome_of(goals.error().code, goals.error().message));
    const auto attempt = [&](std::uint64_t seed) {
      params_.seed = seed;
      unproven_ = false;
      auto outcome = request_.constraints.empty() ? plan(*goals) : plan_constrained(*goals);
      return Attempt{std::move(outcome), unproven_};
    };
    return finish(plan_up_to_twice(params_.seed, attempt, [this] { return time_left_s() > 0; }));
  }

  MotionPipeline::Solved solve(bool avoid_collisions) {
    if (auto wrong = prepare(false)) return {wrong->code, wrong->message, {}};
    collisions_ = avoid_collisions;
    const auto goals = search_goals();
    if (!goals) return {goals.error().code, goals.error().message, {}};
    MotionPipeline::Solved solved{ArmCode::kSuccess, "", {}};
    for (std::size_t i = 0; i < group_->joints.size(); ++i)
      solved.joints[group_->joints[i]] = goals->front()[static_cast<Eigen::Index>(i)];
    return solved;
  }

 private:
  using Goals = tl::expected<std::vector<JointVector>, Status>;

  /// Nothing when there is something to plan with.
  std::optional<MotionOutcome> prepare(bool padded) {
    if (const auto wrong = problem(request_)) return outcome_of(ArmCode::kInvalidRequest, *wrong);
    const auto group = pipeline_.arms().group(request_.group);
    if (!group) return outcome_of(ArmCode::kInvalidRequest, group.error().message);
    group_ = *group;
    const auto start = RobotArms::select(*group_, request_.start);
    if (!start) return outcome_of(ArmCode::kNoJointStates, start.error().message);
    start_ = *start;
    if (auto made = make_checker(padded); !made)
      return outcome_of(ArmCode::kInvalidRequest, made.error().message);
    return std::nullopt;
  }

  Result<void> make_checker(bool padded) {
    const Stopwatch watch;
    auto made = pipeline_.checker(request_.group, request_.start, world_, padded);
    if (!made) return tl::unexpected(made.error());
    checker_.emplace(std::move(*made));
    padded_ = padded;
    times_.checker_s += watch.seconds();
    return {};
  }

  bool near_something(const Goals& goals) {
    if (goals ? !checker_->is_free(start_) : goals.error().code == ArmCode::kGoalInCollision) return true;
    return goals && std::none_of(goals->begin(), goals->end(),
                                 [&](const JointVector& goal) { return checker_->is_free(goal); });
  }

  Goals search_goals() {
    const Stopwatch watch;
    auto goals = std::visit([this](const auto& goal) { return goals_of(goal); }, request_.goal);
    times_.goals_s += watch.seconds();
    return goals;
  }

  Goals goals_of(const NamedState& state) {
    const auto positions = pipeline_.arms().named_state(*group_, state.name);
    if (!positions) return failure(ArmCode::kInvalidRequest, positions.error().message);
    return goals_of(*positions);
  }

  Goals goals_of(const JointPositions& positions) {
    if (positions.empty()) return failure(ArmCode::kInvalidRequest, "no goal was given");
    JointVector goal = start_;
    for (const auto& [name, value] : positions) {
      const auto found = std::find(group_->joints.begin(), group_->joints.end(), name);
      if (found == group_->joints.end())
        return failure(ArmCode::kInvalidRequest, "joint '" + name + "' is not in the group " + group_->name);
      if (!std::isfinite(value))
        return failure(ArmCode::kInvalidRequest, "the goal of " + name + " is not finite");
      goal[found - group_->joints.begin()] = value;
    }
    return std::vector<JointVector>{goal};
  }

  Goals goals_of(const std::vector<ToolTarget>& targets) {
    const auto& params = pipeline_.params();
    return find_goals(pipeline_.arms(), *group_, targets, start_, *checker_,
                      {params.goal_samples, std::min(params.goal_time_s, request_.planning_time_s),
                       params_.seed, request_.cancelled, collisions_});
  }

  MotionOutcome plan(const std::vector<JointVector>& goals) {
    params_.timeout_s = std::max(1e-3, time_left_s());
    PlanResult found;
    try {
      found = search({start_, goals, request_.cancelled});
    } catch (const std::invalid_argument& error) {
      return finish(outcome_of(ArmCode::kInvalidRequest, error.what()));
    }
    times_.search_s += found.search_s;
    times_.shortcut_s += found.shortcut_s;
    if (found.code != PlanCode::kSuccess)
      return finish(outcome_of(static_cast<ArmCode>(found.code), found.message));
    std::vector<double> deviations(found.waypoints.size(),
                                   padded_ ? pipeline_.params().corner_deviation_rad : 0.0);
    return put_in_time(std::move(found.waypoints), {std::move(deviations), kFineCorner}, 1.0);
  }

  MotionOutcome follow_path() {
    auto waypoints = request_.path;
    for (const auto& state : waypoints)
      if (state.size() != start_.size() || !state.allFinite())
        return finish(outcome_of(ArmCode::kInvalidRequest, "a state of the path does not fit the group"));
    if ((waypoints.front() - start_).cwiseAbs().maxCoeff() > kPathStart)
      return finish(outcome_of(ArmCode::kStartMoved, "the robot is not where the path starts"));
    waypoints.front() = start_;
    if (waypoints.size() == 1) waypoints.push_back(request_.path.back());
    if (!proven(waypoints)) {
      if (auto made = make_checker(false); !made)
        return outcome_of(ArmCode::kInvalidRequest, made.error().message);
      if (!proven(waypoints)) return finish(outcome_of(ArmCode::kPathBlocked, "an obstacle blocks the path"));
    }
    std::vector<double> deviations(waypoints.size(), kFineCorner);
    return put_in_time(std::move(waypoints), {std::move(deviations), kFineCorner}, 1.0);
  }

  bool proven(const std::vector<JointVector>& waypoints) {
    for (std::size_t i = 1; i < waypoints.size(); ++i)
      if (!checker_->motion_free(waypoints[i - 1], waypoints[i])) return false;
    return true;
  }

  PlanResult search(const PlanRequest& asked) {
    const int threads = std::max(pipeline_.params().threads, request_.improve ? 2 : 1);
    if (threads == 1) return MotionPlanner(*checker_, params_).plan(asked);
    PlanningTeamParams team;
    team.members.clear();
    for (int i = 0; i < threads; ++i)
      team.members.push_back({params_.planner, params_.seed + static_cast<std::uint64_t>(i)});
    team.threads = threads;
    team.planner = params_;
    return PlanningTeam(*checker_, team).plan(asked, {params_.timeout_s, request_.improve, 1'000'000}).plan;
  }

  MotionOutcome plan_linear() {
    const auto* targets = std::get_if<std::vector<ToolTarget>>(&request_.goal);
    if (targets == nullptr || targets->empty())
      return finish(
          outcome_of(ArmCode::kInvalidRequest, "a straight motion needs poses of a tool as its goal"));
    std::vector<Pose> poses;
    for (const auto& target : *targets) {
      if (target.link != targets->front().link)
        return finish(
            outcome_of(ArmCode::kInvalidRequest, "a straight motion is of one tool: its goals name several"));
      poses.push_back(target.root_T_tool);
    }
    const auto arm = chain_to(pipeline_.arms(), *group_, targets->front().link);
    if (!arm) return finish(outcome_of(arm.error().code, arm.error().message));
    auto found = follow(arm->chain(), poses);
    if (found.end == CartesianEnd::kCollision || found.end == CartesianEnd::kStartInCollision) {
      if (auto made = make_checker(false); !made)
        return outcome_of(ArmCode::kInvalidRequest, made.error().message);
      found = follow(arm->chain(), poses);
    }
    const bool enough = found.fraction >= request_.minimum_fraction && found.fraction > 0.0;
    if (found.end != CartesianEnd::kComplete && !(enough && code_of(found.end) == ArmCode::kPathIncomplete)) {
      auto outcome = outcome_of(code_of(found.end), found.message);
      outcome.fraction = found.fraction;
      return finish(std::move(outcome));
    }
    std::vector<double> deviations(found.waypoints.size(), kFineCorner);
    return put_in_time(std::move(found.waypoints), {std::move(deviations), kFineCorner}, found.fraction);
  }

  CartesianResult follow(const ArmChain& chain, const std::vector<Pose>& poses) {
    const Stopwatch watch;
    CartesianParams params;
    params.timeout_s = std::max(1e-3, time_left_s());
    params.limit_repair_rad = params_.limit_repair_rad;
    CartesianResult found;
    if (auto planner = CartesianPlanner::make(*checker_, chain, params))
      found = planner->plan({start_, poses, request_.cancelled});
    else
      found.message = planner.error().message;
    times_.search_s += watch.seconds();
    return found;
  }

  MotionOutcome plan_constrained(const std::vector<JointVector>& goals) {
    const auto constraint = PathConstraint::make(
        pipeline_.arms().robot(), {group_->joints, other_positions(), request_.constraints, start_});
    if (!constraint)
      return finish(outcome_of(ArmCode::kInvalidRequest, "constraint: " + constraint.error().message));
    ConstrainedPlannerParams params;
    params.timeout_s = std::max(1e-3, time_left_s());
    params.seed = params_.seed;
    params.limit_repair_rad = params_.limit_repair_rad;
    if (!request_.planner.empty()) params.planner = request_.planner;
    ConstrainedPlanResult found;
    try {
      found = ConstrainedPlanner(*checker_, *constraint, params).plan({start_, goals, request_.cancelled});
    } catch (const std::invalid_argument& error) {
      return finish(outcome_of(ArmCode::kInvalidRequest, error.what()));
    }
    times_.search_s += found.search_s;
    times_.shortcut_s += found.shortcut_s;
    if (found.code != PlanCode::kSuccess)
      return finish(
          outcome_of(found.violated >= 0 ? ArmCode::kConstraintViolated : static_cast<ArmCode>(found.code),
                     found.message));
    const auto deviations = corner_deviations(*constraint, found.waypoints, 0.8 * kConstraintError);
    if (!deviations) return finish(outcome_of(ArmCode::kInternal, deviations.error().message));
    return put_in_time(std::move(found.waypoints), {*deviations, 2e-6}, 1.0);
  }

  [[nodiscard]] JointPositions other_positions() const {
    JointPositions others;
    for (const auto& [name, value] : request_.start)
      if (pipeline_.arms().robot().joint(name) &&
          std::find(group_->joints.begin(), group_->joints.end(), name) == group_->joints.end())
        others.emplace(name, value);
    return others;
  }

  MotionOutcome put_in_time(std::vector<JointVector> waypoints, const CornerParams& corners,
                            double fraction) {
    const Stopwatch watch;
    TimeParams times;
    times.velocity_scale = request_.velocity_scale;
    times.acceleration_scale = request_.acceleration_scale;
    auto made = prove_trajectory(*checker_, waypoints, {group_->max_velocity, group_->max_acceleration, {}},
                                 times, corners);
    times_.time_parameterization_s += watch.seconds();
    // The straight path is the same with every seed.
    unproven_ = !made && made.error().code == ErrorCode::kFailed && waypoints.size() > 2;
    if (!made)
      return finish(
          outcome_of(ArmCode::kInternal, "no trajectory along the planned path: " + made.error().message));
    MotionOutcome outcome = outcome_of(ArmCode::kSuccess, "");
    outcome.waypoints = std::move(waypoints);
    outcome.trajectory = std::move(made->trajectory);
    outcome.points = std::move(made->points);
    outcome.fraction = fraction;
    char text[128];
    std::snprintf(text, sizeof text, "planned%s in %.1f ms, takes %.2f s",
                  fraction < 1.0 ? " a part of the path" : "", 1e3 * times_.sum_s(),
                  outcome.trajectory->duration_s());
    outcome.message = text;
    return finish(std::move(outcome));
  }

  [[nodiscard]] double time_left_s() const { return request_.planning_time_s - times_.sum_s(); }

  MotionOutcome finish(MotionOutcome outcome) const {
    outcome.joints = group_->joints;
    outcome.times = times_;
    return outcome;
  }

  MotionPipeline& pipeline_;
  const MotionRequest& request_;
  const CollisionWorld& world_;
  PlannerParams params_;
  const ArmGroup* group_{nullptr};
  JointVector start_;
  std::optional<CollisionChecker> checker_;
  bool padded_{true};
  bool collisions_{true};
  bool unproven_{false};
  MotionTimes times_;
};

}  // namespace

MotionOutcome MotionPipeline::plan(const MotionRequest& request, const CollisionWorld& world) {
  return Run(*this, request, world).run();
}

MotionPipeline::Solved MotionPipeline::solve(const MotionRequest& request, const CollisionWorld& world,
                                             bool avoid_collisions) {
  return Run(*this, request, world).solve(avoid_collisions);
}

}  // namespace extperfc::arm
