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

/// What is known of a graph's nodes relative to each other, as the graph was when this was made.
class RelativeUncertainties {
 public:
  explicit RelativeUncertainties(const PoseGraph& graph);

  /// For every node the covariance of its pose relative to `node`, along that chain of constraints whose
  /// covariance grows least (Olson, Robust and Efficient Robotic Mapping, 2008, section 4.3: the Dijkstra
  /// projection). An upper bound: other chains may add knowledge. Loop closures that the others contradict
  /// are no links. O(constraints log nodes).
  [[nodiscard]] std::vector<RelativeUncertainty> from(std::size_t node) const;

 private:
  /// A constraint's own uncertainty, along the graph's axes.
  struct Step {
    Eigen::Matrix3d covariance;
    double systematic_m{0};
  };
  /// A step as seen from one of its nodes.
  struct Link {
    std::size_t step{0};
    std::size_t other{0};
  };

  std::vector<Pose2> poses_;
  std::vector<Step> steps_;
  std::vector<Link> links_;  ///< those of node n: [first_link_[n], first_link_[n + 1])
  std::vector<std::size_t> first_link_;
};

/// RelativeUncertainties::from(), for one node only.
[[nodiscard]] std::vector<RelativeUncertainty> relative_uncertainty(const PoseGraph& graph, std::size_t from);

}  // namespace extperfc::mapping
