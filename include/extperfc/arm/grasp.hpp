#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/parallel_hand.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

/// An object to grasp. The robot's root frame has its z axis upwards.
struct GraspObject {
  Geometry geometry;  ///< box, cylinder, sphere or cone
  Pose root_T_object{Pose::Identity()};
  /// Of the position, in the root frame [m^2]; symmetric.
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Zero()};
  /// Height in the root frame of what it stands on [m]; the hand stays above it. std::nullopt: no support.
  std::optional<double> support_z_m;
};

struct GraspParams {
  /// Coefficient of friction between pads and objects; 0.05 to 3. Rubber on painted wood: 0.6 to 1.
  double friction{0.6};
  /// Largest accepted tangent of a surface's lean, as a fraction of the friction; (0, 1].
  double friction_ratio{0.8};
  double side_clearance_m{0.002};     ///< between pad and object on either side before closing; 0 to 0.05
  double sigmas{2};                   ///< of the position's error that the opening must cover too; 0 to 5
  double support_clearance_m{0.005};  ///< between hand and support; 0 to 0.1
  double palm_clearance_m{0.005};     ///< between palm and object; 0 to 0.1
  double min_overlap_m{0.006};        ///< of pad and object, along the pad and across; 0.001 to 0.1
  double yaw_step_rad{0.3927};        ///< between closing directions of round objects; 0.05 to 1.6
  double tilt_step_rad{0.3927};       ///< between approaches from above and from the side; 0.05 to 1.6
  double max_tilt_rad{1.5708};        ///< of the approach from straight down; 0 to pi
  double prefer_top{0.3};             ///< penalty of approaches from the side; [0, 1)
  double approach_m{0.1};             ///< straight path from pregrasp to grasp; 0.005 to 0.5
  double lift_m{0.1};                 ///< straight path after closing; 0 to 1
  int max_candidates{200};            ///< 1 to 10,000

  /// An error that names the first value out of its range.
  [[nodiscard]] Result<void> validate() const;
};

/// One grasp of an object. Vectors and poses are in the root frame.
struct GraspCandidate {
  Pose root_T_tip{Pose::Identity()};       ///< when the fingers close
  Pose root_T_pregrasp{Pose::Identity()};  ///< of the tip, approach_m before
  Pose tip_T_object{Pose::Identity()};
  Eigen::Vector3d approach{-Eigen::Vector3d::UnitZ()};  ///< unit vector, from pregrasp to grasp
  double approach_m{0};
  Eigen::Vector3d lift{Eigen::Vector3d::UnitZ()};  ///< unit vector
  double lift_m{0};
  double opening_m{0};      ///< between the pads on the path there
  double closed_m{0};       ///< expected between the pads when they hold
  double lean_rad{0};       ///< angle between the pads' normal and the surface where they touch it
  double support_gap_m{0};  ///< from the hand's lowest point to the support; 1 without support
  double score{0};          ///< (0, 1], more is better
  double spare_m{0};        ///< by which the hand opens wider than opening_m
};

/// Grasps of an object by a parallel hand, best first; equal inputs give equal results.
///
/// Closing directions: a box's three axes; across the axis and along the axis of a cylinder; level ones for a
/// sphere; across the axis of a cone. For each of them approaches from above to the sides by tilt_step_rad,
/// every pose also rotated by half a revolution about the approach. The pad's middle is the centre of the
/// object, or further along a long one, moved away from palm and support where they obstruct it.
///
/// What holds is Coulomb's friction at two contacts: the line between them has to lie within both friction
/// cones (Nguyen 1988, "Constructing force-closure grasps", theorem of two soft fingers). Flat pads meet
/// boxes, cylinders and spheres square: the lean is 0. A standing cone with half-angle a (tan a = radius /
/// height) is met by the lower edges of the pads, because they cannot get under its rim: the surface leans
/// by a, and it holds only when tan a is below the friction, wherever the pads are. They are tried as low as
/// the support lets them, at a quarter and at half of the height. Where nothing is below the rim, the pads
/// span it and the lean is 0.
///
/// The score is the product of: the chance that the object is between the open fingers, the friction that is
/// left over, the overlap of pad and object, the distance of the pads from the centre, the preference of
/// approaches from above, and the distance from the support.
///
/// Errors: a value that is not finite or a size or a parameter out of its range (kInvalidArgument), a mesh
/// (kUnsupported), no grasp, with the reason of each closing direction's failure: too wide for the hand, too
/// thin, position too uncertain, would slip, no room above the support (kFailed). 1 to 11 ms.
[[nodiscard]] Result<std::vector<GraspCandidate>> generate_grasps(const ParallelHand& hand,
                                                                  const GraspObject& object,
                                                                  const GraspParams& params = {});

struct PlaceRequest {
  Pose tip_T_object{Pose::Identity()};   ///< how the hand holds it
  Pose root_T_object{Pose::Identity()};  ///< where it shall stand
  bool any_yaw{false};                   ///< any rotation about the vertical through its origin is accepted
  double opening_m{0};                   ///< between the pads after opening
  std::optional<double> support_z_m;     ///< as in GraspObject
};

struct PlaceParams {
  double lower_m{0.1};                ///< straight path down before opening; 0 to 0.5
  double retreat_m{0.1};              ///< straight path back after opening; 0 to 0.5
  double yaw_step_rad{0.3927};        ///< 0.05 to 1.6
  double support_clearance_m{0.002};  ///< between hand and support; 0 to 0.1
};

/// One pose that places an object. Poses of the tip in the root frame.
struct PlaceCandidate {
  Pose root_T_above{Pose::Identity()};    ///< lower_m above root_T_tip
  Pose root_T_tip{Pose::Identity()};      ///< where the hand opens
  Pose root_T_retreat{Pose::Identity()};  ///< retreat_m back along the approach
  Pose root_T_object{Pose::Identity()};   ///< where it stands then
  double yaw_rad{0};                      ///< from the pose that was asked for, (-pi, pi]
};

/// Poses that place the object, the smallest rotation first. Without any_yaw there is one. Errors: a value
/// that is not finite or a parameter out of its range (kInvalidArgument); the hand would be in the support
/// (kFailed).
[[nodiscard]] Result<std::vector<PlaceCandidate>> place_poses(const ParallelHand& hand,
                                                              const PlaceRequest& request,
                                                              const PlaceParams& params = {});

}  // namespace extperfc::arm
