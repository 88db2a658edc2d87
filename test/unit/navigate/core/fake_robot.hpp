#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/navigate/navigator.hpp"

namespace extperfc::navigate::test {

/// A straight path at steps of 0.1 m, heading along it.
inline Path straight(const Pose2& from, const Pose2& to) {
  Path path;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const int steps = std::max(1, static_cast<int>(std::ceil(length / 0.1)));
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    path.poses.push_back({from.x + f * (to.x - from.x), from.y + f * (to.y - from.y), to.yaw});
  }
  path.cost = length;
  return path;
}

/// Drives towards the end of the path at 0.5 m/s. What else it does is set from outside.
class FakeLocalPlanner : public LocalPlanner {
 public:
  struct Control {
    std::optional<NavError> error;   ///< every command fails
    std::optional<Twist2> velocity;  ///< instead of the right one
    int paths{0};
    Path path;
  };
  explicit FakeLocalPlanner(std::shared_ptr<Control> control) : control_(std::move(control)) {}

  void set_path(const Path& path, const GoalTolerance& tolerance) override {
    control_->path = path;
    ++control_->paths;
    tolerance_ = tolerance;
  }
  NavResult<LocalCommand> command(const CostGrid&, const Footprint&, const LocalState& state, double,
                                  bool) override {
    if (control_->error) return tl::unexpected(*control_->error);
    if (control_->path.poses.empty()) return nav_fail(NavCode::kInvalidRequest, "no path");
    LocalCommand command;
    const Pose2 ahead = between(state.pose, control_->path.poses.back());
    const double away = std::hypot(ahead.x, ahead.y);
    command.at_goal = away < tolerance_.xy_m;
    const double speed = std::min(0.5, away);
    if (away > 1e-6) command.velocity = {speed * ahead.x / away, speed * ahead.y / away, 0};
    if (control_->velocity) command.velocity = *control_->velocity;
    return command;
  }
  void reset() override { control_->path = {}; }

 private:
  std::shared_ptr<Control> control_;
  GoalTolerance tolerance_;
};

/// A navigator with a robot that does exactly what it is commanded, in a local cost map of 8 x 8 m around
/// the origin of odom, which is the map. Plans are straight, or what `plan_error` says.
class FakeRobot {
 public:
  explicit FakeRobot(NavigatorParams params = {})
      : params_(std::move(params)), navigator(params_, std::make_unique<FakeLocalPlanner>(control)) {
    input.costs = &costs;
    input.footprint = &footprint;
  }

  NavigatorOutput cycle(double dt_s = 0.05) {
    now_s += dt_s;
    input.now_s = now_s;
    input.odom_T_base = pose;
    input.map_T_base = pose;
    input.velocity = velocity;
    auto output = navigator.update(input);
    input.jumped = input.map_changed = false;
    if (output.plan) wishes.push_back(*output.plan);
    if (output.plan && answers) navigator.set_plan(answer(*output.plan));
    if (output.end) ends.push_back(*output.end);
    if (!output.event.empty()) events.push_back(output.event);
    velocity = output.command;
    pose = advance(pose, velocity, dt_s);
    return output;
  }
  PlanAnswer answer(const PlanWish& wish) const {
    PlanAnswer made;
    made.id = wish.id;
    if (wish.yield_to_m) {
      if (aside)
        made.path = straight(wish.request.start, *aside);
      else
        made.path = nav_fail(NavCode::kNoPath, "no place");
      return made;
    }
    if (current_blocked) made.blocked_at = wish.request.goal;
    if (plan_error)
      made.path = tl::unexpected(*plan_error);
    else
      made.path = straight(wish.request.start, via ? *via : wish.request.goal);
    if (via && made.path) {
      const Path rest = straight(*via, wish.request.goal);
      made.path->poses.insert(made.path->poses.end(), rest.poses.begin() + 1, rest.poses.end());
    }
    return made;
  }
  /// Until the task ends, `limit_s` at most. False: it did not.
  bool run(double limit_s = 120) {
    const double until_s = now_s + limit_s;
    const auto before = ends.size();
    while (ends.size() == before && now_s < until_s) last = cycle();
    return ends.size() > before;
  }
  void run_for(double seconds) {
    const double until_s = now_s + seconds;
    while (now_s < until_s) last = cycle();
  }
  void drive_to(const Pose2& goal) { (void)navigator.start({++tasks, {goal}, false}); }
  void block(const Eigen::Vector2d& middle_m, double half_m) {
    for (int row = 0; row < costs.height; ++row)
      for (int column = 0; column < costs.width; ++column)
        if ((costs.middle_of({column, row}) - middle_m).cwiseAbs().maxCoeff() <= half_m)
          costs.at({column, row}) = kLethalCost;
  }

  NavigatorParams params_;
  std::shared_ptr<FakeLocalPlanner::Control> control{std::make_shared<FakeLocalPlanner::Control>()};
  Navigator navigator;
  CostGrid costs{make_cost_grid(160, 160, 0.05, {-4, -4}, kFreeCost)};
  Footprint footprint{*Footprint::make({{0.4, 0.4}, {-0.4, 0.4}, {-0.4, -0.4}, {0.4, -0.4}})};
  NavigatorInput input;
  Pose2 pose;
  Twist2 velocity;
  double now_s{100};
  bool answers{true};
  std::optional<NavError> plan_error;
  std::optional<Pose2> via;    ///< of plans
  std::optional<Pose2> aside;  ///< where people can pass
  bool current_blocked{false};
  std::uint64_t tasks{0};
  std::vector<PlanWish> wishes;
  std::vector<NavEnd> ends;
  std::vector<std::string> events;
  NavigatorOutput last;
};

}  // namespace extperfc::navigate::test
