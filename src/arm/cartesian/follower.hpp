#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/cartesian_path.hpp"

#include "arm/cartesian/arm_in_group.hpp"
#include "arm/cartesian/tool_path.hpp"

namespace extperfc::arm {

/// Self-motion of a redundant arm while it follows the path.
struct Course {
  /// Pull towards the middle of the joints' ranges [1/m]; grows towards the limits.
  double centring{0};
  /// Speed along the self-motion [rad/m]; its sign is the side.
  double swing_rad_per_m{0};
  /// How far to go along the self-motion while the tool stands, before it moves [rad]; its sign is the side.
  double elbow_rad{0};
};

/// A state on the path.
struct Station {
  JointVector joints;  ///< of the arm
  double place{0};     ///< on the path [m]
};

struct FollowStop {
  CartesianEnd end{CartesianEnd::kComplete};
  std::optional<Contact> contact;
  int joint{-1};  ///< of the arm, for kLimit
};

/// Follows a path from a state on; see CartesianPlanner for the method.
class Follower {
 public:
  /// All must outlive it. `others`: a state of the group, for the joints that stand still.
  Follower(CollisionChecker& checker, const ArmInGroup& arm, const CartesianParams& params,
           const ToolPath& path, const JointVector& others);

  /// Appends to `route`, which holds the start at least, until the path's end or an obstacle. O(steps).
  [[nodiscard]] FollowStop follow(const Course& course, const std::function<CartesianEnd()>& interrupted,
                                  std::vector<Station>& route);

 private:
  enum class Step { kTaken, kBent, kLost, kBlocked };

  [[nodiscard]] JointVector urge(const Course& course, const JointVector& joints);
  Step try_step(const Course& course, const Station& from, double length, Station& to);
  Step settle(const Station& from, Station& to);
  [[nodiscard]] CartesianEnd move_elbow(double angle_rad, const std::function<CartesianEnd()>& interrupted,
                                        std::vector<Station>& route);
  [[nodiscard]] bool keeps_tolerance(const Station& from, const Station& to) const;
  [[nodiscard]] bool near_line(const Pose& root_T_tip, double place) const;
  [[nodiscard]] FollowStop why_lost(const Station& at) const;
  [[nodiscard]] FollowStop why_blocked(const Station& from, const Station& to);

  CollisionChecker& checker_;
  const ArmInGroup& arm_;
  const CartesianParams& params_;
  const ToolPath& path_;
  JointVector others_;
  JointVector side_;  ///< direction of the self-motion at the last state
};

}  // namespace extperfc::arm
