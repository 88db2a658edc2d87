#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

struct Bodies;

/// Unordered pairs of names (links, objects) whose contact is allowed.
class AllowedPairs {
 public:
  void allow(const std::string& a, const std::string& b);
  /// Allows all pairs of `other` too.
  void allow(const AllowedPairs& other);
  [[nodiscard]] bool allows(const std::string& a, const std::string& b) const;
  [[nodiscard]] const std::set<std::pair<std::string, std::string>>& pairs() const { return pairs_; }

 private:
  std::set<std::pair<std::string, std::string>> pairs_;  ///< the smaller name first
};

struct CollisionModelParams {
  /// Names of the joints that move, in the order of every JointVector; 1 to kMaxJoints of them, none fixed
  /// and none that mimics another.
  std::vector<std::string> joints;
  /// Positions [rad] or [m] of the other joints; 0, or the nearest limit, for those not named.
  std::map<std::string, double> fixed_positions;
  /// Links that may touch. Links without a moving joint between them are never checked against each other.
  AllowedPairs allowed;
  double world_padding_m{0};  ///< distance that the robot keeps from objects of the world; 0 or more
  double self_padding_m{0};   ///< distance between links of the robot; 0 or more
  /// In addition to world_padding_m, for single links; 0 or more.
  std::map<std::string, double> link_padding_m;
  /// How far the spheres of the fast check may stand out sideways of a link's shape; 0.002 to 0.1 m. Smaller
  /// means more spheres.
  double sphere_excess_m{0.01};
};

/// A robot as collision checking sees it: the links between two moving joints make one rigid body; every
/// collision shape is convex (a mesh becomes its convex hull) and is covered by spheres. Poses are in the
/// root link's frame. Immutable; a copy shares the data, so it may be copied freely and used by any thread.
class CollisionModel {
 public:
  /// Errors: a joint or link name that the robot lacks, a joint twice, a fixed or mimic joint, no joints or
  /// too many, a parameter out of its range, a mesh that cannot be read.
  [[nodiscard]] static Result<CollisionModel> make(const RobotModel& robot,
                                                   const CollisionModelParams& params);

  [[nodiscard]] int joint_count() const;
  [[nodiscard]] const std::vector<std::string>& joint_names() const;
  /// Of the moving joints; a continuous joint has -infinity and +infinity.
  [[nodiscard]] const JointLimits& limits() const;
  /// root_T_link at `positions` [rad] or [m]; nothing when there is no such link.
  [[nodiscard]] std::optional<Pose> link_pose(const JointVector& positions, const std::string& link) const;
  /// Spheres that cover the moving links.
  [[nodiscard]] int sphere_count() const;

  [[nodiscard]] const Bodies& bodies() const { return *bodies_; }

 private:
  explicit CollisionModel(std::shared_ptr<const Bodies> bodies) : bodies_(std::move(bodies)) {}
  std::shared_ptr<const Bodies> bodies_;
};

}  // namespace extperfc::arm
