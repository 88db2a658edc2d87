#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/collision_model.hpp"

#include "arm/collision/convex_part.hpp"
#include "arm/collision/sphere_cover.hpp"

namespace extperfc::arm {

/// A rigid body: everything between two moving joints. Body 0 does not move and has no joint.
struct Body {
  int parent{-1};
  int joint{-1};         ///< index into a JointVector
  double multiplier{1};  ///< value of the joint = multiplier * position + offset
  double offset{0};
  bool prismatic{false};
  Pose parent_T_joint{Pose::Identity()};  ///< rotated so that the motion is about or along z
  double lower{0}, upper{0};              ///< of the value; prismatic only
};

/// A collision shape of a link.
struct LinkPart {
  int link{0};
  int body{0};
  std::shared_ptr<const ConvexPart> part;
  Pose body_T_part{Pose::Identity()};
  std::vector<Ball> cover;  ///< in the part's frame; empty for body 0
};

struct Bodies {
  std::vector<std::string> joint_names;
  JointLimits limits;
  std::vector<Body> bodies;  ///< a parent stands before its children
  std::vector<std::string> links;
  std::vector<int> body_of_link;
  std::vector<Pose> body_T_link;
  std::vector<LinkPart> parts;
  CollisionModelParams params;

  [[nodiscard]] std::optional<int> link(const std::string& name) const;
  /// What an object touching `link` must keep clear of world objects.
  [[nodiscard]] double world_padding_m(const std::string& link) const;
};

/// root_T_body of every body. `poses` is resized.
void body_poses(const Bodies& bodies, const double* positions, std::vector<Pose>& poses);

/// How far points of something on a body can be from each joint that moves it, for all positions.
struct AxisReach {
  std::vector<double>
      from_axis;  ///< per body: largest distance from the axis of its joint; 1 if prismatic; 0 if unmoved
  Ball in_root;   ///< holds the object for all positions
};
[[nodiscard]] AxisReach reach_of(const Bodies& bodies, int body, const Ball& in_body);

/// The body from which both hang; one of them when it carries the other.
[[nodiscard]] int common_ancestor(const Bodies& bodies, int a, int b);

/// Bounds of the motion of an object against an ancestor of its body while every joint keeps its rate.
struct MotionBound {
  double speed{0};         ///< of any of its points
  double acceleration{0};  ///< of any of its points, in the ancestor's frame
  double displacement{0};  ///< of any of its points beside the motion [m]; motion_bound() leaves it 0
};
/// `from_axis` as in AxisReach, `rates` per body.
[[nodiscard]] MotionBound motion_bound(const Bodies& bodies, int ancestor, int body,
                                       const std::vector<double>& from_axis,
                                       const std::vector<double>& rates);

/// Bound of how far points of an object are displaced against an ancestor of its body, per radian (Euclidean
/// norm) that the joint positions differ; `from_axis` as in AxisReach.
[[nodiscard]] double displacement_per_rad(const Bodies& bodies, int ancestor, int body,
                                          const std::vector<double>& from_axis);

}  // namespace extperfc::arm
