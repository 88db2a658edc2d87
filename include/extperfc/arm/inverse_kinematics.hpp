#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>
#include <kdl/frames.hpp>
#include <kdl/jntarray.hpp>
#include <tl/expected.hpp>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/kinematics.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::arm {

/// How far the tip may be from its target, per axis of the target's frame; +infinity frees an axis.
/// Tolerances up to 1 mm and 1 mrad aim at the target itself; wider ones are room that the solver uses.
struct IkTolerance {
  Eigen::Vector3d position_m{1e-5, 1e-5, 1e-5};       ///< > 0: the tip's origin along x, y, z
  Eigen::Vector3d orientation_rad{1e-5, 1e-5, 1e-5};  ///< > 0: the rotation vector of target_R_tip
};

/// What decides between the solutions of a redundant arm. Both act in the null space of the task: they move
/// the arm along its solutions to a local minimum, but for few cases (0.4 %) that end a little before it.
enum class IkObjective {
  kNone,      ///< the first one found
  kNearSeed,  ///< smallest sum of squared distances from the seed
  kMidRange,  ///< away from limits: smallest sum of squared distances from mid-range, in half ranges
};

/// Whether a configuration may be used, e.g. is free of collisions.
using IkPredicate = std::function<bool(const JointVector&)>;

/// Equal inputs give equal results as long as `timeout_s` does not end the search: everything else that ends
/// it is counted, not timed.
struct IkOptions {
  IkTolerance tolerance;
  double timeout_s{0.005};    ///< >= 0, wall time; infinity: max_restarts alone ends the search
  int max_restarts{100};      ///< >= 0, from random positions after the one from the seed
  std::uint64_t rng_seed{1};  ///< of the restarts
  IkObjective objective{IkObjective::kNone};
  IkPredicate accept;  ///< empty: everything. Its time counts
};

struct IkSolution {
  JointVector joints;          ///< within the limits; continuous joints within half a revolution of the seed
  double position_error_m{0};  ///< distance of the origins
  double orientation_error_rad{0};  ///< angle between the orientations
  int restarts{0};                  ///< that it took
};

/// Why there is no solution.
enum class IkReason {
  kInvalid,     ///< a target that is no rigid transform, a seed of another size or not finite, a bad option
  kOutOfReach,  ///< farther than the links reach, or not found with the joint limits lifted either
  kLimits,      ///< found with the joint limits lifted only
  kCollision,   ///< found, but `accept` refused every one
  kTimeout,     ///< the time was up before the search was at its end
};

[[nodiscard]] const char* to_string(IkReason reason);

struct IkFailure {
  IkReason reason{IkReason::kInvalid};
  bool proven{false};   ///< no search can find one: kInvalid, and kOutOfReach by the lengths of the links
  JointVector closest;  ///< the closest approach, or the last one refused; empty for kInvalid
  double position_error_m{0};       ///< of `closest`
  double orientation_error_rad{0};  ///< of `closest`
  int restarts{0};
  int refused{0};  ///< solutions that `accept` refused
};

using IkResult = tl::expected<IkSolution, IkFailure>;

/// Inverse kinematics of one chain. Immutable; every method may be called from several threads at once.
///
/// A damped least-squares descent (Levenberg-Marquardt; Nakamura and Hanafusa 1986, Wampler 1986) on the
/// pose's error, in the box of the joint limits with an active set, restarted from random positions; then,
/// where asked for, a descent of the objective in the null space. Positions count in metres, orientations in
/// radians.
class InverseKinematics {
 public:
  explicit InverseKinematics(ArmChain chain);

  [[nodiscard]] const ArmChain& chain() const { return chain_; }

  /// One solution. `target` is root_T_tip; a seed outside the limits is moved to the nearest position within.
  /// About 10 us for a reachable pose and seven joints; a failure takes all restarts and the search for its
  /// reason.
  [[nodiscard]] IkResult solve(const Pose& target, const JointVector& seed,
                               const IkOptions& options = {}) const;
  [[nodiscard]] IkResult solve(const KDL::Frame& target, const KDL::JntArray& seed,
                               const IkOptions& options = {}) const;

 private:
  ArmChain chain_;
};

}  // namespace extperfc::arm
