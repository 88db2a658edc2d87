#pragma once

#include <vector>

#include "extperfc/simulate/bodies.hpp"

#include "simulate/bodies/physics_world.hpp"
#include "simulate/bodies/rigid_tree.hpp"

namespace extperfc::simulate {

/// What both kinds of robot share: the description that they are built from.
struct RobotPlan {
  const RobotModel* model{nullptr};
  RigidTree tree;
  std::vector<GripperFingers> grippers;
};

/// The moving links of a robot in the physics world.
class RobotBody {
 public:
  RobotBody(const RobotPlan& plan, std::vector<double> start_positions);
  virtual ~RobotBody() = default;

  RobotBody(const RobotBody&) = delete;
  RobotBody& operator=(const RobotBody&) = delete;

  /// Values that are not finite are ignored; positions are kept inside the joint's limits.
  void set_target(int joint, const JointTarget& target);
  [[nodiscard]] const JointTarget& target(int joint) const { return targets_[joint]; }
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<double>& velocities() const { return velocities_; }

  /// Around every step: where the root is at its end.
  virtual void before_step(const Pose& world_T_root) = 0;
  virtual void after_step() = 0;
  /// The root stands elsewhere, at rest, now.
  virtual void jump(const Pose& world_T_root) = 0;

  /// What the motor did in the last step [N m] or [N]; 0 where there is no motor.
  [[nodiscard]] virtual double motor_effort(int joint) const = 0;
  /// Frame of a group that moves, after a step.
  [[nodiscard]] virtual Pose world_T_group(int group) const = 0;

  /// From now on the hand carries this loose body. `overlap_m`: how deep each finger was in it
  /// when the last step began. Returns where the driven finger stays.
  virtual double hold(int gripper, int body, double overlap_m) = 0;
  virtual void release(int gripper) = 0;

 protected:
  const RobotPlan& plan() const { return *plan_; }
  /// Largest speed that the joint takes [rad/s] or [m/s].
  [[nodiscard]] double speed_limit(int joint) const { return speed_limits_[joint]; }
  void set_state(int joint, double position, double velocity);

 private:
  const RobotPlan* plan_;
  std::vector<JointTarget> targets_;
  std::vector<double> positions_;
  std::vector<double> velocities_;
  std::vector<double> speed_limits_;
};

/// Fingers move at most this fast [m/s], as Baxter's electric gripper does; a description's limit may be far
/// above it, and a finger must not jump over what it shall touch.
inline constexpr double kFingerSpeed = 0.15;

}  // namespace extperfc::simulate
