#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

namespace extperfc::mapping {

/// Where key frame `to` was measured to be, seen from key frame `from`.
struct Relation {
  std::size_t from{0};
  std::size_t to{0};
  Pose2 from_T_to;
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};  ///< of x, y, yaw in the frame of `from`
  bool sighting{false};  ///< of an old place: may be wrong, so it pulls less the more it disagrees
  double fit{0};         ///< of a sighting: share of the scan that the place explains
};

/// Key frames and the relations between them; relaxing finds the poses that agree with all of them best
/// (Gauss-Newton; Grisetti et al., A Tutorial on Graph-Based SLAM, 2010). Node 0 stays where it is.
class PoseGraph {
 public:
  void add_node(const Pose2& pose) { poses_.push_back(pose); }
  void add(const Relation& relation) { relations_.push_back(relation); }

  [[nodiscard]] const std::vector<Pose2>& poses() const { return poses_; }
  void set_poses(std::vector<Pose2> poses) { poses_ = std::move(poses); }
  [[nodiscard]] const std::vector<Relation>& relations() const { return relations_; }
  std::vector<Relation>& relations() { return relations_; }

  /// Moves the nodes from `first_free` on. False when the equations could not be solved; nothing moves then.
  bool relax(std::size_t first_free, int iterations);

  /// How far a relation is from what the poses say: x, y [m], yaw [rad] in the frame of its `from`.
  [[nodiscard]] Eigen::Vector3d error(const Relation& relation) const;
  /// The same in standard deviations, squared (a chi-square of three degrees of freedom).
  [[nodiscard]] double squared_error(const Relation& relation) const;

 private:
  std::vector<Pose2> poses_;
  std::vector<Relation> relations_;
};

}  // namespace extperfc::mapping
