#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/navigate/collision_guard.hpp"
#include "extperfc/navigate/local_planner.hpp"
#include "extperfc/world/pose.hpp"

#include "test/support/building.hpp"
#include "test/support/grid_route.hpp"

namespace extperfc {

/// Somebody who walks to and fro along a route; waits while the robot is close ahead, for a while.
struct Pedestrian {
  std::vector<Eigen::Vector2d> route_m;
  double speed_m_s{0.8};
  double radius_m{0.25};
  Eigen::Vector2d at_m{0, 0};
  Eigen::Vector2d velocity_m_s{0, 0};
  std::size_t next{1};
  double waited_s{0};

  void begin() {
    at_m = route_m.front();
    next = 1;
    waited_s = 0;
  }

  void step(double dt_s, const std::vector<Eigen::Vector2d>& robot_m) {
    Eigen::Vector2d to = route_m[next] - at_m;
    while (to.norm() < speed_m_s * dt_s) {
      if (++next == route_m.size()) back();
      to = route_m[next] - at_m;
    }
    const Eigen::Vector2d direction = to.normalized();
    const bool close = polygon_distance(robot_m, at_m + 0.3 * direction) < radius_m + 0.1;
    velocity_m_s = close ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(speed_m_s * direction);
    at_m += dt_s * velocity_m_s;
    waited_s = close ? waited_s + dt_s : 0;
    if (waited_s > 3) back();
  }

 private:
  void back() {
    std::vector<Eigen::Vector2d> rest(route_m.rbegin() + static_cast<std::ptrdiff_t>(route_m.size() - next),
                                      route_m.rend());
    rest.insert(rest.begin(), at_m);
    if (rest.size() < 2) rest.assign(route_m.rbegin(), route_m.rend());
    route_m = std::move(rest);
    next = 1;
    waited_s = 0;
  }
};

inline Pedestrian make_pedestrian(const navigate::Path& route, double speed_m_s) {
  Pedestrian person;
  person.speed_m_s = speed_m_s;
  person.route_m.reserve(route.poses.size());
  for (const Pose2& pose : route.poses) person.route_m.emplace_back(pose.x, pose.y);
  person.begin();
  return person;
}

struct DriveOptions {
  navigate::VelocityLimits base{1.0, -1.0, 1.0, 1.5, 1.0, 1.0, 3.14};  ///< of the simulated base
  double control_s{0.05};
  double physics_s{0.01};
  double latency_s{0.1};  ///< from a command to the base
  double scan_s{0.1};     ///< period
  double range_sigma_m{0.01};
  double speed_sigma_m_s{0.02};  ///< of measured velocities
  double pose_sigma_m{0.003};    ///< of the pose that the planner sees
  double pose_sigma_rad{0.003};
  double localization_sigma_m{0.01};  ///< of where the path lies in the local frame, drawn every second
  double localization_sigma_rad{0.003};
  double local_size_m{6};
  bool guard{true};  ///< a CollisionGuard checks the commands
  double max_time_s{120};
};

struct DriveResult {
  bool reached{false};
  bool blocked{false};
  int contacts{0};         ///< times that the true footprint began to touch a box
  int person_contacts{0};  ///< times that the robot drove into a person
  int guarded{0};          ///< commands that the guard changed
  double time_s{0};
  double driven_m{0};
  double planned_m{0};
  double mean_speed_m_s{0};  ///< until the robot is 0.3 m from the goal
  double min_clearance_m{std::numeric_limits<double>::infinity()};
  double swing_m{0};            ///< driven within 0.3 m of the goal, beyond the distance itself
  double swing_rad{0};          ///< rotated there, beyond the error at the beginning
  double jerk_m_s2{0};          ///< RMS of the second difference of commands / control period: roughness
  std::vector<double> cycle_s;  ///< CPU time of each command
  Pose2 end;
};

/// A base in a building with a lidar and a rolling cost map: closes the loop around a local planner. All
/// noise is seeded.
class DriveSimulation {
 public:
  DriveSimulation(Building building, navigate::Footprint footprint, const DriveOptions& options,
                  std::uint64_t seed)
      : building_(std::move(building)), footprint_(std::move(footprint)), options_(options), rng_(seed) {
    const double cell = 0.05;
    const auto cells = [&](double length) { return static_cast<int>(std::ceil(length / cell)) + 80; };
    // The obstacle map's cells are not those of the building.
    seen_ = navigate::make_cost_grid(cells(building_.size_m.x()), cells(building_.size_m.y()), cell,
                                     {-2 + rng_.uniform(0, cell), -2 + rng_.uniform(0, cell)}, 0);
  }

  std::vector<Pedestrian> people;
  double speed_factor{1};

  DriveResult drive(navigate::LocalPlanner& planner, const navigate::Path& path,
                    const navigate::GoalTolerance& tolerance, const Pose2& start) {
    pose_ = start;
    velocity_ = {};
    queue_.clear();
    path_ = path;
    tolerance_ = tolerance;
    result_ = {};
    result_.planned_m = length_m(path);
    touches_ = false;
    person_touches_ = false;
    commands_.clear();
    for (Pedestrian& person : people) person.begin();
    time_s_ = 0;
    scan();
    planner.set_path(displaced_path(), tolerance);
    while (time_s_ < options_.max_time_s && !result_.reached && !result_.blocked) cycle(planner);
    finish();
    return result_;
  }

 private:
  [[nodiscard]] navigate::Path displaced_path() {
    const Pose2 error{rng_.normal(0, options_.localization_sigma_m),
                      rng_.normal(0, options_.localization_sigma_m),
                      rng_.normal(0, options_.localization_sigma_rad)};
    navigate::Path path = path_;
    const Pose2 about{pose_.x, pose_.y, 0};
    for (Pose2& pose : path.poses) pose = compose(about, compose(error, between(about, pose)));
    return path;
  }

  void cycle(navigate::LocalPlanner& planner) {
    if (time_s_ >= next_shift_s_ || time_s_ == 0) {
      planner.set_path(displaced_path(), tolerance_);
      next_shift_s_ = time_s_ + 1;
    }
    if (time_s_ >= next_scan_s_ || time_s_ == 0) {
      scan();
      next_scan_s_ = time_s_ + options_.scan_s;
    }
    const navigate::CostGrid costs = local_costs();
    const navigate::LocalState state = measured_state();
    const CpuStopwatch watch;
    const auto command = planner.command(costs, footprint_, state, options_.control_s, false);
    result_.cycle_s.push_back(watch.seconds());
    Twist2 sent = command ? command->velocity : Twist2{};
    if (options_.guard) {
      const navigate::GuardedCommand guarded = guard_.admit(footprint_, state.velocity, sent, time_s_);
      if (guarded.action != navigate::GuardAction::kPassed) ++result_.guarded;
      sent = guarded.velocity;
    }
    commands_.push_back(sent);
    if (!command)
      result_.blocked = true;
    else
      result_.reached = command->at_goal;
    queue_.push_back({time_s_ + options_.latency_s, sent});
    for (double left = options_.control_s; left > 1e-9; left -= options_.physics_s) step(options_.physics_s);
  }

  [[nodiscard]] navigate::LocalState measured_state() {
    navigate::LocalState state;
    state.pose = {pose_.x + rng_.normal(0, options_.pose_sigma_m),
                  pose_.y + rng_.normal(0, options_.pose_sigma_m),
                  wrap_angle(pose_.yaw + rng_.normal(0, options_.pose_sigma_rad))};
    state.velocity = {velocity_.vx + rng_.normal(0, options_.speed_sigma_m_s),
                      velocity_.vy + rng_.normal(0, options_.speed_sigma_m_s),
                      velocity_.wz + rng_.normal(0, options_.speed_sigma_m_s)};
    state.speed_factor = speed_factor;
    for (const Pedestrian& person : people) {
      if ((person.at_m - Eigen::Vector2d(pose_.x, pose_.y)).norm() > 6) continue;
      state.people.push_back({person.at_m + Eigen::Vector2d(rng_.normal(0, 0.03), rng_.normal(0, 0.03)),
                              person.velocity_m_s + Eigen::Vector2d(rng_.normal(0, 0.1), rng_.normal(0, 0.1)),
                              person.radius_m});
    }
    return state;
  }

  void step(double dt_s) {
    while (!queue_.empty() && queue_.front().at_s <= time_s_ + 1e-9) {
      active_ = queue_.front().velocity;
      queue_.pop_front();
    }
    velocity_ = limited_change(active_, velocity_, options_.base, dt_s);
    const Pose2 before = pose_;
    pose_ = advance(pose_, velocity_, dt_s);
    time_s_ += dt_s;
    const auto body = placed(footprint_.corners_m(), pose_);
    for (Pedestrian& person : people) person.step(dt_s, body);
    record(before, body);
  }

  void record(const Pose2& before, const std::vector<Eigen::Vector2d>& body) {
    const double moved = std::hypot(pose_.x - before.x, pose_.y - before.y);
    result_.driven_m += moved;
    const bool touches = std::any_of(building_.boxes.begin(), building_.boxes.end(),
                                     [&](const FloorBox& box) { return overlaps(box, body); });
    if (touches && !touches_) ++result_.contacts;
    touches_ = touches;
    const bool moves = std::hypot(velocity_.vx, velocity_.vy) > 0.05;
    const bool person_touches = std::any_of(people.begin(), people.end(), [&](const Pedestrian& person) {
      return polygon_distance(body, person.at_m) < person.radius_m;
    });
    if (person_touches && !person_touches_ && moves) ++result_.person_contacts;
    person_touches_ = person_touches;
    const Pose2& goal = path_.poses.back();
    const double left = std::hypot(goal.x - pose_.x, goal.y - pose_.y);
    if (left < 0.3 && approach_s_ < 0) {
      approach_s_ = time_s_;
      approach_driven_m_ = result_.driven_m;
      approach_rotated_rad_ = 0;
      approach_error_rad_ = std::abs(wrap_angle(goal.yaw - pose_.yaw));
    }
    if (approach_s_ >= 0) approach_rotated_rad_ += std::abs(wrap_angle(pose_.yaw - before.yaw));
  }

  void finish() {
    result_.time_s = time_s_;
    result_.end = pose_;
    const double until = approach_s_ > 0 ? approach_s_ : time_s_;
    const double driven = approach_s_ > 0 ? approach_driven_m_ : result_.driven_m;
    result_.mean_speed_m_s = until > 0 ? driven / until : 0;
    if (approach_s_ >= 0) {
      result_.swing_m = result_.driven_m - approach_driven_m_ - 0.3;
      result_.swing_rad = approach_rotated_rad_ - approach_error_rad_;
    }
    double sum = 0;
    for (std::size_t i = 2; i < commands_.size(); ++i) {
      const double x = commands_[i].vx - 2 * commands_[i - 1].vx + commands_[i - 2].vx;
      const double y = commands_[i].vy - 2 * commands_[i - 1].vy + commands_[i - 2].vy;
      sum += x * x + y * y;
    }
    if (commands_.size() > 2)
      result_.jerk_m_s2 = std::sqrt(sum / static_cast<double>(commands_.size() - 2)) / options_.control_s;
    approach_s_ = -1;
    next_scan_s_ = next_shift_s_ = 0;
  }

  /// Clears along the rays, then marks their ends.
  void scan() {
    constexpr int kRays = 360;
    constexpr double kRange_m = 8;
    const Eigen::Vector2d from(pose_.x, pose_.y);
    std::vector<Eigen::Vector2d> points;
    points.reserve(kRays);
    std::vector<navigate::Cell> ends;
    ends.reserve(kRays);
    for (int ray = 0; ray < kRays; ++ray) {
      const double angle = kTwoPi * ray / kRays;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      double range = kRange_m;
      for (const FloorBox& box : building_.boxes) range = std::min(range, ray_range(box, from, direction));
      for (const Pedestrian& person : people)
        range = std::min(range, ray_range(FloorDisc{person.at_m, person.radius_m}, from, direction));
      const bool hit = range < kRange_m;
      range += rng_.normal(0, options_.range_sigma_m);
      for (double along = 0; along < range - 0.1; along += 0.04)
        if (const auto cell = seen_.cell_of(from + along * direction)) seen_.at(*cell) = 0;
      if (!hit) continue;
      points.emplace_back(range * std::cos(angle - pose_.yaw), range * std::sin(angle - pose_.yaw));
      if (const auto cell = seen_.cell_of(from + range * direction)) ends.push_back(*cell);
    }
    guard_.set_points(std::move(points), time_s_);
    for (const navigate::Cell& cell : ends) seen_.at(cell) = navigate::kLethalCost;
  }

  [[nodiscard]] navigate::CostGrid local_costs() const {
    const int cells = static_cast<int>(options_.local_size_m / seen_.resolution_m);
    const navigate::Cell middle = seen_.cell_around({pose_.x, pose_.y});
    navigate::Cell low{middle.column - cells / 2, middle.row - cells / 2};
    navigate::CostGrid costs = navigate::make_cost_grid(
        cells, cells, seen_.resolution_m,
        seen_.origin_m + seen_.resolution_m * Eigen::Vector2d(low.column, low.row), 0);
    for (int row = 0; row < cells; ++row)
      for (int column = 0; column < cells; ++column) {
        const navigate::Cell from{low.column + column, low.row + row};
        if (seen_.contains(from)) costs.at({column, row}) = seen_.at(from);
      }
    costs.may_hold_unknown = false;
    inflate(costs, {footprint_.inscribed_radius_m(), 0.8, 5});
    return costs;
  }

  struct Queued {
    double at_s{0};
    Twist2 velocity;
  };

  Building building_;
  navigate::Footprint footprint_;
  DriveOptions options_;
  Rng rng_;
  navigate::CostGrid seen_;
  navigate::CollisionGuard guard_{navigate::GuardParams{}};
  navigate::Path path_;
  navigate::GoalTolerance tolerance_;
  Pose2 pose_;
  Twist2 velocity_;
  Twist2 active_;
  std::deque<Queued> queue_;
  std::vector<Twist2> commands_;
  DriveResult result_;
  double time_s_{0};
  double next_scan_s_{0};
  double next_shift_s_{0};
  double approach_s_{-1};
  double approach_driven_m_{0};
  double approach_rotated_rad_{0};
  double approach_error_rad_{0};
  bool touches_{false};
  bool person_touches_{false};
};

/// Ahead from a pose, one pose every 5 cm.
inline navigate::Path straight_path(const Pose2& from, double length_m) {
  navigate::Path path;
  const auto count = static_cast<int>(std::lround(length_m / 0.05));
  path.poses.reserve(static_cast<std::size_t>(count) + 1);
  for (int i = 0; i <= count; ++i) path.poses.push_back(compose(from, {length_m * i / count, 0, 0}));
  return path;
}

/// The reference robot's chassis [m].
inline navigate::Footprint chassis() {
  return *navigate::Footprint::make(
      {{0.4064, 0.3937}, {-0.4064, 0.3937}, {-0.4064, -0.3937}, {0.4064, -0.3937}});
}

}  // namespace extperfc
