#pragma once

#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/kinematics.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

struct JoggerParams {
  /// Of each joint of the arm, [rad/s], above 0; empty: the robot's limits.
  JointVector max_velocity;
  /// Of every joint, 0.01 to 100 rad/s^2; also how it brakes.
  double max_acceleration_rad_s2{5.0};
  /// Age of the latest command at which the motion ramps to zero, 0.01 to 5 s.
  double command_timeout_s{0.2};
  /// How long the robot goes on before it obeys: the path proven free ahead is longer by what the arm covers
  /// in this time. 0 to 1 s.
  double reaction_s{0.02};
  /// Time constant of the approach to a joint's limit: at distance d the joint is no faster than d over this.
  /// 0.01 to 5 s; more is taken where braking needs it.
  double limit_approach_s{0.5};
  /// Below `slow` of the Jacobian's smallest singular value (rows [m] and [rad] per joint) a twist that
  /// lowers it is slowed down, at `stop` it ends; 0 < stop < slow.
  double singularity_slow{0.06};
  double singularity_stop{0.02};
  /// Distance of the measured from the commanded positions at which the motion stops, 0.001 to 1 rad.
  double max_lag_rad{0.2};
};

/// What is wanted of the arm; one of these.
struct JogCommand {
  enum class Kind {
    kStop,
    kJoints,     ///< `joint_velocity`
    kTwistRoot,  ///< `twist` along the axes of the chain's root
    kTwistTip,   ///< `twist` along the axes of the tip
  };
  Kind kind{Kind::kStop};
  JointVector joint_velocity;  ///< of the arm [rad/s]
  /// Of the tip: its origin's velocity [m/s], then its angular velocity [rad/s].
  Eigen::Matrix<double, 6, 1> twist{Eigen::Matrix<double, 6, 1>::Zero()};
  double stamp_s{0};  ///< on the clock that step() gets
};

/// What holds the motion back, or keeps it from starting; stable numbers.
enum class JogHindrance {
  kNone = 0,
  kJointLimit = 1,
  kCollision = 2,
  kSingularity = 3,
  kTimeout = 4,   ///< the command is too old, or from the future
  kLag = 5,       ///< the robot does not follow the commanded positions
  kBadInput = 6,  ///< sizes that do not fit, values that are not finite, a step that is not in (0, 0.2] s
};

/// Name for logs, e.g. "joint_limit".
[[nodiscard]] const char* to_string(JogHindrance hindrance);

struct JogStep {
  /// Of the group: where to be at the end of the step. Empty while no step had usable input yet.
  JointVector positions;
  JointVector velocities;  ///< of the group, at the end of the step [rad/s]
  bool moving{false};      ///< the velocity is not zero
  /// The strongest limitation of the speed; with `moving` false: what stops it.
  JogHindrance hindrance{JogHindrance::kNone};
  double scale{1};                 ///< fraction of the wanted velocity that is permitted, [0, 1]
  std::string joint;               ///< of kJointLimit
  std::optional<Contact> contact;  ///< of kCollision: the pair that would touch, or does
};

/// Jogs one arm: at a fixed rate it converts the latest command into the next joint command.
///
/// Safety by induction: the arm always has a proven stopping motion. It brakes with all joints in proportion,
/// the slowest to brake deciding, so the stopping motion is a straight segment in joint space, from q along v
/// for max_j |v_j| / (2 a) + reaction_s. A step is taken only when it and the stopping motion after it passed
/// CollisionChecker::motion_free() and stay within the limits; else less of the step is tried, and in the end
/// the braking that the last step had proven. So while the world is the checker's and the joints of the group
/// that are not the arm's stand still, no step collides, independent of the commands. An arm that is in
/// collision already (an object was added, or moved) may move only so that its deepest penetration gets less,
/// slowly.
///
/// Twists go through the damped least-squares inverse of the Jacobian (Nakamura and Hanafusa, "Inverse
/// kinematic solutions with singularity robustness", 1986; the damping follows the smallest singular value as
/// in Maciejewski and Klein, 1988), with the null space pulled away from joint limits. What slows a motion
/// down scales the whole vector, so the direction stays; near a singularity the damping bends it.
///
/// The commands start at the measured positions and go on from the last command, so lag does not add up.
/// No clock inside, no threads: the same calls give the same steps. Not thread-safe.
class Jogger {
 public:
  /// The checker must outlive it. Errors (kInvalidArgument): a joint of the chain that is not in the group, a
  /// parameter out of its range.
  [[nodiscard]] static Result<Jogger> make(CollisionChecker& checker, const ArmChain& chain,
                                           const JoggerParams& params = {});
  Jogger(Jogger&&) noexcept;
  Jogger& operator=(Jogger&&) noexcept;
  ~Jogger();

  /// Replaces the command. One that does not fit stops the motion, and the steps say so (kBadInput).
  void command(const JogCommand& command);
  /// Forgets the motion: the next step starts at rest from the measured positions.
  void reset();
  /// Another world, for the same model, from the next step on; it must outlive the jogger.
  void use(CollisionChecker& checker);

  /// `now_s`: on the clock of the stamps. `measured`: positions of the group; joints that are not the arm's
  /// are taken from it every time. `dt_s`: until the next step, in (0, 0.2].
  [[nodiscard]] JogStep step(double now_s, const JointVector& measured, double dt_s);

 private:
  struct Core;
  explicit Jogger(std::unique_ptr<Core> core);
  std::unique_ptr<Core> core_;
};

}  // namespace extperfc::arm
