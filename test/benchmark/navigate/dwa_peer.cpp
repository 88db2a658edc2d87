#include "test/benchmark/navigate/dwa_peer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace extperfc::benchmark {

namespace {

using navigate::BaseKind;
using navigate::Contact;
using navigate::CostGrid;
using navigate::Footprint;
using navigate::GoalTolerance;
using navigate::LocalCommand;
using navigate::LocalState;
using navigate::NavResult;
using navigate::Path;
using navigate::VelocityLimits;

constexpr int kVx = 8;
constexpr int kVy = 5;
constexpr int kWz = 15;
constexpr double kHorizon_s = 1.7;
constexpr double kStep_s = 0.1;
constexpr double kLocalGoal_m = 2.0;
constexpr double kPathWeight = 32;
constexpr double kGoalWeight = 24;
constexpr double kForwardPoint_m = 0.325;
constexpr double kCostWeight = 0.01;
constexpr double kNever = std::numeric_limits<double>::infinity();

double step_of(double low, double high, int i, int count) {
  return count > 1 ? low + (high - low) * i / (count - 1) : low;
}

class Dwa : public navigate::LocalPlanner {
 public:
  Dwa(const VelocityLimits& limits, BaseKind base) : limits_(limits), base_(base) {}

  void set_path(const Path& path, const GoalTolerance& tolerance) override {
    path_ = path;
    tolerance_ = tolerance;
  }
  void reset() override { path_ = {}; }
  NavResult<LocalCommand> command(const CostGrid& costs, const Footprint& footprint, const LocalState& state,
                                  double dt_s, bool with_candidates) override;

 private:
  [[nodiscard]] double cost(const CostGrid& costs, const Footprint& footprint, const Pose2& from,
                            const Twist2& twist) const;
  [[nodiscard]] double path_distance(const Eigen::Vector2d& at) const;
  [[nodiscard]] Twist2 best(const CostGrid& costs, const Footprint& footprint, const LocalState& state,
                            double dt_s, double& best_cost) const;
  void place(const Pose2& pose);

  VelocityLimits limits_;
  BaseKind base_;
  Path path_;
  GoalTolerance tolerance_;
  std::size_t nearest_{0};
  Eigen::Vector2d local_goal_{0, 0};
  bool latched_{false};
  double idle_s_{0};
};

void Dwa::place(const Pose2& pose) {
  double smallest = kNever;
  for (std::size_t i = 0; i < path_.poses.size(); ++i) {
    const double distance = std::hypot(path_.poses[i].x - pose.x, path_.poses[i].y - pose.y);
    if (distance < smallest) {
      smallest = distance;
      nearest_ = i;
    }
  }
  double length = 0;
  std::size_t goal = nearest_;
  while (goal + 1 < path_.poses.size() && length < kLocalGoal_m) {
    length += std::hypot(path_.poses[goal + 1].x - path_.poses[goal].x,
                         path_.poses[goal + 1].y - path_.poses[goal].y);
    ++goal;
  }
  local_goal_ = {path_.poses[goal].x, path_.poses[goal].y};
}

double Dwa::path_distance(const Eigen::Vector2d& at) const {
  double smallest = kNever;
  const std::size_t end = std::min(path_.poses.size(), nearest_ + 80);
  for (std::size_t i = nearest_ > 10 ? nearest_ - 10 : 0; i < end; i += 2)
    smallest = std::min(smallest, std::hypot(path_.poses[i].x - at.x(), path_.poses[i].y - at.y()));
  return smallest;
}

double Dwa::cost(const CostGrid& costs, const Footprint& footprint, const Pose2& from,
                 const Twist2& twist) const {
  double highest = 0;
  Pose2 pose = from;
  for (double time_s = kStep_s; time_s <= kHorizon_s + 1e-9; time_s += kStep_s) {
    pose = advance(from, twist, time_s);
    if (contact(costs, footprint, pose) != Contact::kFree) return kNever;
    if (const auto cell = costs.cell_of({pose.x, pose.y}))
      highest = std::max(highest, static_cast<double>(costs.at(*cell)));
  }
  const Eigen::Vector2d end(pose.x, pose.y);
  const Eigen::Vector2d front =
      end + kForwardPoint_m * Eigen::Vector2d(std::cos(pose.yaw), std::sin(pose.yaw));
  return kPathWeight * (path_distance(end) + path_distance(front)) +
         kGoalWeight * ((local_goal_ - end).norm() + (local_goal_ - front).norm()) + kCostWeight * highest;
}

Twist2 Dwa::best(const CostGrid& costs, const Footprint& footprint, const LocalState& state, double dt_s,
                 double& best_cost) const {
  const Twist2& now = state.velocity;
  const double window_s = std::max(dt_s, 0.1);  // of the controller's nominal 10 Hz
  const double low_x = std::max(limits_.min_vx_m_s, now.vx - limits_.acc_x_m_s2 * window_s);
  const double high_x = std::min(limits_.max_vx_m_s, now.vx + limits_.acc_x_m_s2 * window_s);
  const double low_y = std::max(-limits_.max_vy_m_s, now.vy - limits_.acc_y_m_s2 * window_s);
  const double high_y = std::min(limits_.max_vy_m_s, now.vy + limits_.acc_y_m_s2 * window_s);
  const double low_w = std::max(-limits_.max_wz_rad_s, now.wz - limits_.acc_wz_rad_s2 * window_s);
  const double high_w = std::min(limits_.max_wz_rad_s, now.wz + limits_.acc_wz_rad_s2 * window_s);
  const int sideways = base_ == BaseKind::kHolonomic ? kVy : 1;
  Twist2 result;
  for (int i = 0; i < kVx; ++i)
    for (int j = 0; j < sideways; ++j)
      for (int k = 0; k < kWz; ++k) {
        const Twist2 twist{step_of(low_x, high_x, i, kVx), sideways > 1 ? step_of(low_y, high_y, j, kVy) : 0,
                           step_of(low_w, high_w, k, kWz)};
        const double rated = cost(costs, footprint, state.pose, limited(twist, limits_));
        if (rated >= best_cost) continue;
        best_cost = rated;
        result = limited(twist, limits_);
      }
  return result;
}

NavResult<LocalCommand> Dwa::command(const CostGrid& costs, const Footprint& footprint,
                                     const LocalState& state, double dt_s, bool /*with_candidates*/) {
  LocalCommand out;
  place(state.pose);
  const Pose2 error = between(state.pose, path_.poses.back());
  latched_ = std::hypot(error.x, error.y) < tolerance_.xy_m;
  if (latched_) {  // stops, then rotates
    const bool aligned = std::abs(error.yaw) < tolerance_.yaw_rad;
    const double wz = aligned ? 0 : std::copysign(std::min(0.5, 1.5 * std::abs(error.yaw) + 0.1), error.yaw);
    out.velocity = limited_change({0, 0, wz}, state.velocity, limits_, dt_s);
    if (aligned) out.velocity = {};
    out.at_goal = aligned && std::hypot(state.velocity.vx, state.velocity.vy) < 0.05 &&
                  std::abs(state.velocity.wz) < 0.1;
    return out;
  }
  double best_cost = kNever;
  out.velocity = best(costs, footprint, state, dt_s, best_cost);
  const bool idles = std::hypot(out.velocity.vx, out.velocity.vy) < 0.02 && std::abs(out.velocity.wz) < 0.04;
  idle_s_ = idles || !std::isfinite(best_cost) ? idle_s_ + dt_s : 0;
  if (idle_s_ > 1.5)
    return navigate::nav_fail(navigate::NavCode::kBlocked, "no velocity of the window is free");
  return out;
}

}  // namespace

std::unique_ptr<navigate::LocalPlanner> make_dwa(const VelocityLimits& limits, BaseKind base) {
  return std::make_unique<Dwa>(limits, base);
}

}  // namespace extperfc::benchmark
