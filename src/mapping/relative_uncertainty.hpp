#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "mapping/pose_graph.hpp"

namespace extperfc::mapping {

/// Standard deviation of the position along its least known direction.
[[nodiscard]] double widest_sigma_m(const Eigen::Matrix3d& covariance);

/// What is known of a node's pose as seen from another node.
struct RelativeUncertainty {
  bool connected{false};
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Zero()};  ///< of x, y, yaw in the frame of the other node
  double systematic_m{0};  ///< a bias that grows with the distance, such as that of the wheels' diameters

  /// Within this distance of its pose, in any direction, the node stands with three standard deviations [m].
  [[nodiscard]] double reach_m() const;
  [[nodiscard]] double reach_rad() const;
  /// Nothing is known of the rotation: the robot was carried on every chain to there.
  [[nodiscard]] bool is_unknown() const;
  /// Standard deviation of the position along the direction in which it is known least, bias included [m].
  [[nodiscard]] double sigma_m() const;
  /// With the bias as two standard deviations.
  [[nodiscard]] Eigen::Matrix3d with_bias() const;
};

/// What is known of node `constraint.to` relative to node 0, from what is known of `constraint.from`.
[[nodiscard]] RelativeUncertainty extend(const RelativeUncertainty& from, const PoseGraph& graph,
                                         const Constraint& constraint);

/// For every node the covariance of its pose relative to `from`, along that chain of constraints whose
/// covariance grows least (Olson, Robust and Efficient Robotic Mapping, 2008, section 4.3: the Dijkstra
/// projection). An upper bound: other chains may add knowledge. Loop closures that the others contradict are
/// no links. O(constraints log nodes).
[[nodiscard]] std::vector<RelativeUncertainty> relative_uncertainty(const PoseGraph& graph, std::size_t from);

}  // namespace extperfc::mapping
