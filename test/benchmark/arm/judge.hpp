#pragma once

#include <functional>
#include <optional>
#include <string>

#include "extperfc/arm/collision_checker.hpp"

namespace extperfc::benchmark {

/// A collision on a path that was called free.
struct HiddenCollision {
  double parameter{0};  ///< of the path
  arm::Contact contact;
};

/// Looks for collisions on paths, state after state, by Bullet alone. It shares neither the planner's spheres
/// nor its proof: states are at most `step` apart, and more only where Bullet's distance at the last one
/// leaves no room for a collision in between: no joint of the robot moves a point by more than kReach_m per
/// radian.
class Judge {
 public:
  /// `exact` is a checker without spheres (CollisionCheckerParams::spheres false).
  explicit Judge(arm::CollisionChecker& exact) : exact_(exact) {}

  /// The first collision on a path of straight segments, at states `step_rad` apart (Euclidean).
  [[nodiscard]] std::optional<HiddenCollision> find(const std::vector<arm::JointVector>& waypoints,
                                                    double step_rad);
  /// The first collision among the states at 0, step_s, 2 step_s ... duration_s.
  [[nodiscard]] std::optional<HiddenCollision> find(
      const std::function<arm::JointVector(double time_s)>& position, double duration_s, double step_s);

  /// States that Bullet saw.
  [[nodiscard]] long states() const { return states_; }

 private:
  /// State `i` of a path of `count`.
  using State = std::function<arm::JointVector(int i)>;
  [[nodiscard]] std::optional<int> first_contact(const State& state, int count);

  arm::CollisionChecker& exact_;
  arm::Contact contact_;
  long states_{0};
};

}  // namespace extperfc::benchmark
