#include "simulate/trajectory/goal_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace extperfc::simulate {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLimitSlackRad = 1e-3;  // joint limits are rounded when they travel as text
using Order = std::vector<std::size_t>;  // of each followed joint in the goal's lists

tl::unexpected<TrajectoryEnd> refuse(TrajectoryCode code, std::string message) {
  return tl::unexpected<TrajectoryEnd>(TrajectoryEnd{code, std::move(message)});
}

std::string names_of(const std::vector<FollowedJoint>& joints) {
  std::string text;
  for (const auto& joint : joints) text += (text.empty() ? "" : " ") + joint.name;
  return text;
}

TrajectoryResult<Order> order_of(const std::vector<std::string>& names,
                                 const std::vector<FollowedJoint>& joints) {
  const auto wrong = [&](const std::string& what) {
    return refuse(TrajectoryCode::kInvalidJoints, what + "; this arm wants " + names_of(joints));
  };
  Order order;
  for (const auto& joint : joints) {
    const auto found = std::find(names.begin(), names.end(), joint.name);
    if (found == names.end()) return wrong(joint.name + " is missing in the trajectory");
    order.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(names.begin(), name, *name) != name) return wrong(*name + " is given twice");
    const bool known = std::any_of(joints.begin(), joints.end(), [&](auto& j) { return j.name == *name; });
    if (!known) return wrong("'" + *name + "' is not a joint of this arm");
  }
  return order;
}

TrajectoryResult<Eigen::VectorXd> sorted(const std::vector<double>& values, const Order& order,
                                         const std::string& what) {
  if (values.size() != order.size())
    return refuse(TrajectoryCode::kInvalidGoal, what + " has " + std::to_string(values.size()) +
                                                    " values for " + std::to_string(order.size()) +
                                                    " joints");
  Eigen::VectorXd result(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!std::isfinite(values[order[i]]))
      return refuse(TrajectoryCode::kInvalidGoal, what + " has a value that is not finite");
    result[static_cast<Eigen::Index>(i)] = values[order[i]];
  }
  return result;
}

TrajectoryResult<std::optional<Eigen::VectorXd>> sorted_if_given(const std::vector<double>& values,
                                                                 const Order& order,
                                                                 const std::string& what) {
  if (values.empty()) return std::nullopt;
  return sorted(values, order, what).map([](Eigen::VectorXd v) { return std::optional(std::move(v)); });
}

TrajectoryResult<void> check_limits(const Eigen::VectorXd& position, const std::vector<FollowedJoint>& joints,
                                    const std::string& what) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double value = position[static_cast<Eigen::Index>(i)];
    if (value < joints[i].lower - kLimitSlackRad || value > joints[i].upper + kLimitSlackRad)
      return refuse(TrajectoryCode::kInvalidGoal, what + " puts " + joints[i].name + " at " + to_text(value) +
                                                      " rad, outside its limits [" +
                                                      to_text(joints[i].lower) + ", " +
                                                      to_text(joints[i].upper) + "]");
  }
  return {};
}

TrajectoryResult<JointKnot> knot_of(const TrajectoryPoint& point, const Order& order,
                                    const std::vector<FollowedJoint>& joints, const std::string& what) {
  if (!std::isfinite(point.time_s) || point.time_s < 0)
    return refuse(TrajectoryCode::kInvalidGoal, what + ": its time must be 0 or more");
  if (!point.accelerations.empty() && point.velocities.empty())
    return refuse(TrajectoryCode::kInvalidGoal, what + " has accelerations without velocities");
  auto position = sorted(point.positions, order, what + ": positions");
  if (!position) return tl::unexpected(position.error());
  auto velocity = sorted_if_given(point.velocities, order, what + ": velocities");
  if (!velocity) return tl::unexpected(velocity.error());
  auto acceleration = sorted_if_given(point.accelerations, order, what + ": accelerations");
  if (!acceleration) return tl::unexpected(acceleration.error());
  if (auto inside = check_limits(*position, joints, what); !inside) return tl::unexpected(inside.error());
  return JointKnot{point.time_s, std::move(*position), std::move(*velocity), std::move(*acceleration)};
}

TrajectoryResult<std::vector<JointKnot>> knots_of(const TrajectoryGoal& goal, const Order& order,
                                                  const std::vector<FollowedJoint>& joints) {
  if (goal.points.empty()) return refuse(TrajectoryCode::kInvalidGoal, "the trajectory has no points");
  std::vector<JointKnot> knots;
  for (const auto& point : goal.points) {
    const auto what = "point " + std::to_string(knots.size());
    auto knot = knot_of(point, order, joints, what);
    if (!knot) return tl::unexpected(knot.error());
    if (!knots.empty() && knot->time_s <= knots.back().time_s)
      return refuse(TrajectoryCode::kInvalidGoal, what + ": its time " + to_text(knot->time_s) +
                                                      " s is not after the point before, " +
                                                      to_text(knots.back().time_s) + " s");
    knots.push_back(std::move(*knot));
  }
  return knots;
}

double bound(double given, double standard) {
  if (given < 0) return kInfinity;
  return given > 0 ? given : standard;
}

TrajectoryResult<MotionBounds> bounds_of(const std::vector<JointTolerance>& tolerances,
                                         const std::vector<FollowedJoint>& joints, const char* what,
                                         double position, double velocity) {
  const auto n = static_cast<Eigen::Index>(joints.size());
  MotionBounds bounds{Eigen::VectorXd::Constant(n, position), Eigen::VectorXd::Constant(n, velocity),
                      Eigen::VectorXd::Constant(n, kInfinity)};
  for (const auto& tolerance : tolerances) {
    const auto found = std::find_if(joints.begin(), joints.end(),
                                    [&](const auto& joint) { return joint.name == tolerance.joint; });
    if (found == joints.end())
      return refuse(TrajectoryCode::kInvalidJoints,
                    std::string(what) + " names '" + tolerance.joint + "'; this arm has " + names_of(joints));
    for (const double value : {tolerance.position, tolerance.velocity, tolerance.acceleration})
      if (std::isnan(value))
        return refuse(TrajectoryCode::kInvalidGoal,
                      std::string(what) + " of " + tolerance.joint + " is not a number");
    const auto i = static_cast<Eigen::Index>(found - joints.begin());
    bounds.position[i] = bound(tolerance.position, position);
    bounds.velocity[i] = bound(tolerance.velocity, velocity);
    bounds.acceleration[i] = bound(tolerance.acceleration, kInfinity);
  }
  return bounds;
}

TrajectoryResult<double> start_of(const TrajectoryGoal& goal, const TrajectoryFollowerParams& params,
                                  double now_s) {
  const double start_s = goal.start_s.value_or(now_s);
  const double end_s = start_s + goal.points.back().time_s;
  if (start_s < now_s && end_s <= now_s)
    return refuse(TrajectoryCode::kOldHeaderTimestamp,
                  "the trajectory would have ended " + to_text(now_s - end_s) +
                      " s ago; stamp it with the time of its start, or with 0 for now");
  if (!(start_s - now_s <= params.longest_wait_for_start_s))
    return refuse(TrajectoryCode::kInvalidGoal,
                  "the trajectory starts " + to_text(start_s - now_s) +
                      " s from now; does its sender use the simulated clock (use_sim_time)?");
  return start_s;
}

}  // namespace

std::string to_text(double value) {
  std::array<char, 64> text{};
  (void)std::snprintf(text.data(), text.size(), "%.3f", value);
  return text.data();
}

TrajectoryResult<CheckedGoal> check_goal(const TrajectoryGoal& goal, const std::vector<FollowedJoint>& joints,
                                         const TrajectoryFollowerParams& params, double now_s) {
  const auto order = order_of(goal.joints, joints);
  if (!order) return tl::unexpected(order.error());
  auto knots = knots_of(goal, *order, joints);
  if (!knots) return tl::unexpected(knots.error());
  auto path = bounds_of(goal.path_tolerance, joints, "path_tolerance", params.path_tolerance_rad, kInfinity);
  if (!path) return tl::unexpected(path.error());
  auto end = bounds_of(goal.goal_tolerance, joints, "goal_tolerance", params.goal_tolerance_rad,
                       params.stopped_velocity_rad_s);
  if (!end) return tl::unexpected(end.error());
  if (!(goal.goal_time_tolerance_s >= 0))
    return refuse(TrajectoryCode::kInvalidGoal, "goal_time_tolerance must be 0 or more");
  const auto start_s = start_of(goal, params, now_s);
  if (!start_s) return tl::unexpected(start_s.error());

  for (auto& knot : *knots) knot.time_s += *start_s;
  const auto over = [&](const JointKnot& knot) { return *start_s < now_s && knot.time_s <= now_s; };
  knots->erase(knots->begin(), std::find_if_not(knots->begin(), knots->end(), over));
  const double goal_time_s = goal.goal_time_tolerance_s > 0 ? goal.goal_time_tolerance_s : params.goal_time_s;
  return CheckedGoal{std::move(*knots), *start_s, goal_time_s, std::move(*path), std::move(*end)};
}

}  // namespace extperfc::simulate
