#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

namespace extperfc::mapping {

/// An edge of the pose graph: measured pose of key frame `to` in the frame of key frame `from`.
struct Constraint {
  std::size_t from{0};
  std::size_t to{0};
  Pose2 from_T_to;
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};  ///< of x, y, yaw in the frame of `from`
  bool is_loop_closure{false};                           ///< may be wrong, so a robust loss applies
  double fit{0};  ///< of a loop closure: fraction of the scan that the submap explains

  [[nodiscard]] Eigen::Matrix3d covariance() const;  ///< large where nothing is known
  /// A step that tells nothing of where `to` is: the robot was carried.
  [[nodiscard]] bool is_unknown() const;

  static constexpr double kUnknownRad2 = 2.0;  ///< a rotation of larger variance is unknown
};

/// Key frames as nodes and constraints as edges; optimize() finds the poses that agree with all constraints
/// best (Gauss-Newton; Grisetti et al., A Tutorial on Graph-Based SLAM, 2010). Node 0 is fixed.
class PoseGraph {
 public:
  void add_node(const Pose2& pose) { poses_.push_back(pose); }
  void add(const Constraint& constraint) { constraints_.push_back(constraint); }

  [[nodiscard]] const std::vector<Pose2>& poses() const { return poses_; }
  void set_poses(std::vector<Pose2> poses) { poses_ = std::move(poses); }
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return constraints_; }
  std::vector<Constraint>& constraints() { return constraints_; }

  /// Moves the nodes from `first_free` on. False when the equations could not be solved; nothing moves then.
  bool optimize(std::size_t first_free, int iterations);
  /// Moves all nodes by graduated non-convexity (Yang, Antonante, Tzoumas and Carlone 2020): loop closures
  /// count in full at first, however far off, and those that the others contradict lose their weight step by
  /// step. For closures that were accepted together.
  bool optimize_gradually();

  /// Residual of a constraint at the present poses: x, y [m], yaw [rad] in the frame of its `from`.
  [[nodiscard]] Eigen::Vector3d error(const Constraint& constraint) const;
  /// The same in standard deviations, squared (a chi-square of three degrees of freedom).
  [[nodiscard]] double squared_error(const Constraint& constraint) const;

  /// The chi-square at which a loop closure has a quarter of its weight.
  static constexpr double kDoubtfulSquaredError = 40.0;

 private:
  bool optimize(std::size_t first_free, int iterations, double loss_scale);

  std::vector<Pose2> poses_;
  std::vector<Constraint> constraints_;
};

}  // namespace extperfc::mapping
