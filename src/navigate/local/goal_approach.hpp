#pragma once

#include "extperfc/navigate/local_planner.hpp"

namespace extperfc::navigate {

/// Drives the last stretch straight to the goal and stops there without swinging: speeds fall with the
/// distance, and once inside a part of the tolerance the base stays where it is until it leaves the
/// tolerance.
class GoalApproach {
 public:
  GoalApproach(const VelocityLimits& limits, BaseKind base) : limits_(limits), base_(base) {}

  /// A goal that is the same within a small motion keeps the state; another one begins anew, and false is
  /// returned.
  bool set_goal(const Pose2& goal, const GoalTolerance& tolerance);
  [[nodiscard]] bool near(const Pose2& pose, double remaining_m) const;
  [[nodiscard]] Twist2 velocity(const Pose2& pose);
  [[nodiscard]] bool within(const Pose2& pose) const;
  [[nodiscard]] bool settled() const { return phase_ == Phase::kSettled; }
  [[nodiscard]] const Pose2& goal() const { return goal_; }

 private:
  enum class Phase { kApproach, kRotate, kSettled };

  [[nodiscard]] Twist2 holonomic(const Pose2& error) const;
  [[nodiscard]] Twist2 differential(const Pose2& error) const;
  [[nodiscard]] double rotation(double error_rad) const;
  [[nodiscard]] double speed(double distance_m) const;
  void choose_phase(const Pose2& error);

  VelocityLimits limits_;
  BaseKind base_;
  Pose2 goal_;
  GoalTolerance tolerance_;
  Phase phase_{Phase::kApproach};
};

}  // namespace extperfc::navigate
