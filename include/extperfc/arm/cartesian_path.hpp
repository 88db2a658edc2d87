#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/kinematics.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::arm {

class ArmInGroup;

/// How a straight path ended; stable numbers, they cross action results.
enum class CartesianEnd {
  kComplete = 0,
  kInvalidRequest = 1,      ///< sizes, values that are not finite, a pose that is no rigid transform, no pose
  kStartOutsideLimits = 2,  ///< beyond limit_repair_rad
  kStartInCollision = 3,
  kLimit = 4,        ///< the arm could follow further but for a joint's limit
  kCollision = 5,    ///< an obstacle blocks the tool or the arm
  kSingularity = 6,  ///< the pose is within reach, but not without a jump of the joints
  kOutOfReach = 7,   ///< no joint values bring the tool there
  kCancelled = 8,
  kTimeout = 9,
};

/// Name for logs, e.g. "out_of_reach".
[[nodiscard]] const char* to_string(CartesianEnd end);

struct CartesianParams {
  /// Largest distance of the tool from the line anywhere on the path, 1e-6 to 0.1 m.
  double position_tolerance_m{1e-4};
  /// Largest angle between the tool and the orientation that belongs to the nearest place of the line, 1e-5
  /// to 0.5 rad.
  double orientation_tolerance_rad{1e-3};
  /// Longest step along the path, 1e-3 to 0.5 m (a radian counts as kMetresPerRad).
  double max_step_m{0.05};
  /// Largest rotation of a joint within one step; a step that needs more is halved. 0.01 to 1 rad.
  double max_joint_step_rad{0.2};
  /// How many self-motions of a redundant arm are tried before the longest path is returned; 1 to 1000. Arms
  /// without redundancy have one.
  int max_attempts{24};
  /// A start this far outside a joint's limits is moved onto them first; 0 to 0.2 rad.
  double limit_repair_rad{0.05};
  /// Wall time, above 0 s. Returns the longest path found until then.
  double timeout_s{5.0};
};

struct CartesianRequest {
  JointVector start;                ///< of the group
  std::vector<Pose> poses;          ///< root_T_tip of the chain, one after the other from the start's pose
  std::function<bool()> cancelled;  ///< asked at every step; may be empty
};

struct CartesianResult {
  CartesianEnd end{CartesianEnd::kInvalidRequest};
  std::string message;                 ///< one line for people: what ended it, and where
  double fraction{0};                  ///< of the whole path, in [0, 1]; 1 exactly when complete
  std::vector<JointVector> waypoints;  ///< of the group; starts at the start; straight segments proven free
  /// Where on the path each waypoint is, in [0, 1]; never falls. Every pose of the request that was reached
  /// has a waypoint.
  std::vector<double> progress;
  std::optional<Contact> contact;  ///< of kStartInCollision and kCollision
  std::string joint;               ///< of kStartOutsideLimits and kLimit
  int attempts{0};
};

/// Straight lines of one tip from pose to pose: the position moves along the line, the orientation rotates
/// about one axis (slerp), both evenly.
///
/// The joints follow the solution from the start on without ever leaving it: a step along the path, Newton's
/// method from the last state (damped least squares in the box of the limits), and the step is halved until
/// it converges, no joint rotates by more than max_joint_step_rad, and the tool keeps its tolerance at the
/// quarters of the joint-space segment, with a tenth to spare for what lies between. Every segment passed
/// CollisionChecker::motion_free(). So the path ends early rather than jump.
///
/// A redundant arm has a choice of self-motion on the path. The first attempt keeps away from limits
/// (gradient projection: Liegeois 1977); when it ends early, others go back a part of the path and move the
/// elbow to one side or the other, while the tool stands or while it moves. The first that is complete wins,
/// else the longest.
///
/// Joints of the group that the chain lacks stand still. Equal requests give equal results unless the time
/// runs out. Some 0.5 ms for 0.3 m of free path and 10 ms when all attempts are made, most of it collision
/// checks. Not thread-safe.
class CartesianPlanner {
 public:
  /// What one radian counts for in `fraction` and `progress` [m].
  static constexpr double kMetresPerRad = 0.25;

  /// The checker must outlive it. Errors (kInvalidArgument): a joint of the chain that is not in the group; a
  /// parameter out of its range.
  [[nodiscard]] static Result<CartesianPlanner> make(CollisionChecker& checker, const ArmChain& chain,
                                                     const CartesianParams& params = {});
  CartesianPlanner(CartesianPlanner&&) noexcept;
  CartesianPlanner& operator=(CartesianPlanner&&) noexcept;
  ~CartesianPlanner();

  [[nodiscard]] CartesianResult plan(const CartesianRequest& request);

 private:
  CartesianPlanner(CollisionChecker& checker, ArmInGroup arm, const CartesianParams& params);

  CollisionChecker* checker_;
  std::unique_ptr<const ArmInGroup> arm_;
  CartesianParams params_;
};

}  // namespace extperfc::arm
