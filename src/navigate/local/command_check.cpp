#include "navigate/local/command_check.hpp"

#include <algorithm>
#include <cmath>

#include "navigate/costs/polygon.hpp"

namespace extperfc::navigate {

namespace {

constexpr double kStep_s = 0.05;
constexpr double kMaxTime_s = 5;
constexpr double kPersonClearance_m = 0.1;
constexpr double kStands_m_s = 0.02;
constexpr double kHits_m = 0.1;  // from a person's middle: no motion but standing

double speed_of(const Twist2& twist) {
  return std::hypot(twist.vx, twist.vy);
}

bool at_rest(const Twist2& twist) {
  return speed_of(twist) < 1e-3 && std::abs(twist.wz) < 1e-3;
}

}  // namespace

double distance_m(const Footprint& footprint, const Eigen::Vector2d& point_m) {
  const auto& corners_m = footprint.corners_m();
  return contains(corners_m, point_m) ? 0 : distance_to_edges_m(corners_m, point_m);
}

/// Who is too near already must not come nearer by the robot's motion.
bool CommandCheck::people_free(const Pose2& pose, double time_s, double speed_m_s) const {
  if (speed_m_s < kStands_m_s) return true;  // who walks into a robot that stands is not hit by it
  return std::all_of(state_.people.begin(), state_.people.end(), [&](const MovingObstacle& person) {
    const Eigen::Vector2d at = person.position_m + time_s * person.velocity_m_s;
    const double kept_m = person.radius_m + kPersonClearance_m;
    const double gap_m = gap(pose, at);
    return gap_m > kept_m || (gap_m > kHits_m && gap_m >= gap(state_.pose, at));
  });
}

double CommandCheck::gap(const Pose2& pose, const Eigen::Vector2d& at) const {
  const Pose2 in_base = between(pose, {at.x(), at.y(), 0});
  return distance_m(footprint_, {in_base.x, in_base.y});
}

bool CommandCheck::free(const Twist2& current, const Twist2& command, double dt_s) const {
  Pose2 pose = state_.pose;
  Twist2 now = current;
  const double reacts_until_s = dt_s + rules_.reaction_s;
  for (double time_s = 0; time_s < kMaxTime_s;) {
    const bool brakes = time_s >= reacts_until_s - 1e-9;
    const double step_s = brakes ? kStep_s : std::min(kStep_s, reacts_until_s - time_s);
    now = limited_change(brakes ? Twist2{} : command, now, rules_.limits, step_s);
    if (brakes && at_rest(now)) return true;
    const Pose2 next = advance(pose, now, step_s);
    if (contact_along(costs_, footprint_, pose, next) != Contact::kFree) return false;
    time_s += step_s;
    pose = next;
    if (!people_free(pose, time_s, speed_of(now))) return false;
  }
  return true;
}

}  // namespace extperfc::navigate
