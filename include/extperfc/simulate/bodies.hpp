#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::simulate {

struct BodiesParams {
  double step_s{1.0 / 240.0};  ///< length of a step, (0, 1/100] [s]
  bool dynamic{false};         ///< joints driven by motors with limited effort instead of set positions
  int solver_iterations{50};   ///< of the constraint solver, [10, 500]
  double gravity_m_s2{9.81};   ///< downwards, [0, 20]
  bool hold_gripped{true};  ///< add a fixed constraint while both fingers of a gripper touch one loose body
};

/// How a joint is driven in dynamic mode. In kinematic mode `position` is taken as it is.
enum class Drive { kPosition, kVelocity, kEffort };

/// What a joint shall do from the next step on.
struct JointTarget {
  Drive drive{Drive::kPosition};
  double position{0};    ///< [rad] or [m]
  double velocity{0};    ///< [rad/s] or [m/s]; with kPosition: feed-forward
  double effort{0};      ///< [N m] or [N]; with kEffort: applied as it is, gravity is not compensated here
  double max_effort{0};  ///< limit of the motor; 0: the joint's own
};

/// Rigid-body world (Bullet): robot, loose objects, fixed objects, people. One thread at a time.
///
/// Deterministic: the same calls give the same states, bit for bit, on one build and machine.
/// The robot's root is kinematic: it is where set_root() says. Joints: in kinematic mode positions are set,
/// links push loose bodies and a gripper's fingers stop when both touch one loose body, which then is
/// carried; in dynamic mode each arm is a btMultiBody with a motor per joint. In both modes:
/// - The robot's links meet the world, not each other.
/// - A gripper holds what both pads touch from inside while it is commanded to close, and lets go when it is
/// commanded
///   to open by more than 0.5 mm. Fingers move with 0.15 m/s at most.
/// - Friction and restitution of two bodies multiply. Fingers have 1.5, other links 0.6.
/// - Meshes count as their convex hulls. Wheels (continuous joints) are part of the chassis and are where
///   commanded.
/// - Loose bodies that rest for 2 s sleep, at no cost; what touches or moves something wakes them.
class Bodies {
 public:
  /// `start_positions` has a value per joint of the robot. Errors: a parameter out of range, a loose body
  /// without mass, a shape that Bullet cannot take.
  [[nodiscard]] static Result<std::unique_ptr<Bodies>> make(const BodiesParams& params,
                                                            const RobotModel& robot, const WorldSpec& world,
                                                            const Pose& world_T_root,
                                                            const std::vector<double>& start_positions);
  virtual ~Bodies() = default;

  /// Where the root is at the end of the next step. What is farther than 5 m/s or 10 rad/s allow is a jump:
  /// the robot is there at rest, with what its grippers hold. Not finite: ignored.
  virtual void set_root(const Pose& world_T_root) = 0;
  /// True when the robot's chassis (links that hang on the root by fixed joints), put there, would overlap a
  /// fixed or movable body or a person by more than 2 mm. The floor (anything below 3 cm) does not count.
  [[nodiscard]] virtual bool root_collides(const Pose& world_T_root) = 0;

  /// `joint` is an index into RobotModel::joints(). Mimic joints follow on their own. Positions are kept
  /// inside the joint's limits; a target that is not finite is ignored. It holds until the next one; the
  /// first one is the start position.
  virtual void set_target(int joint, const JointTarget& target) = 0;
  virtual void step() = 0;

  [[nodiscard]] virtual double position(int joint) const = 0;  ///< [rad] or [m]
  [[nodiscard]] virtual double velocity(int joint) const = 0;  ///< [rad/s] or [m/s]
  /// What the motor applied in the last step [N m] or [N]; about 0 for fingers that hold something with
  /// `hold_gripped` (see grip_force). Kinematic: the gravity torque that a motor would hold.
  [[nodiscard]] virtual double effort(int joint) const = 0;
  /// Efforts that hold the robot's arms against gravity where they are, one per joint [N m] or [N].
  [[nodiscard]] virtual std::vector<double> gravity_efforts() const = 0;

  [[nodiscard]] virtual Pose world_T_link(int link) const = 0;
  [[nodiscard]] virtual Pose world_T_body(int body) const = 0;              ///< index into WorldSpec::bodies
  [[nodiscard]] virtual Eigen::Vector3d body_velocity(int body) const = 0;  ///< linear, world frame [m/s]

  /// Puts a movable or loose body somewhere, at rest; a gripper that holds it lets go. Error for a fixed
  /// body, a wrong index, a pose that is not finite.
  [[nodiscard]] virtual Result<void> move_body(int body, const Pose& world_T_body) = 0;
  /// Index into WorldSpec::people. Where the person is at the end of the next step; faster than 5 m/s: at
  /// once.
  virtual void set_person(int person, const Pose2& pose) = 0;

  /// Loose body that both fingers of this gripper touch; `finger_joint` is the one that the other finger
  /// mimics.
  [[nodiscard]] virtual std::optional<int> gripped(int finger_joint) const = 0;
  /// Force with which the fingers press [N]: measured at the pads in dynamic mode, until `hold_gripped` fixes
  /// the body; then, and in kinematic mode, the motor's limit while it is commanded to close.
  [[nodiscard]] virtual double grip_force(int finger_joint) const = 0;
};

}  // namespace extperfc::simulate
