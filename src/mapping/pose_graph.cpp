#include "mapping/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/block_equations.hpp"

namespace extperfc::mapping {

namespace {

// A loop closure with this chi-square has a quarter of its weight (Geman-McClure).
constexpr double kDoubtfulSquaredError = 40.0;
constexpr double kSettledM = 1e-5;

Eigen::Matrix3d jacobian_from(const Pose2& from, const Pose2& to) {
  const double c = std::cos(from.yaw);
  const double s = std::sin(from.yaw);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  Eigen::Matrix3d j;
  j << -c, -s, -s * dx + c * dy, s, -c, -c * dx - s * dy, 0, 0, -1;
  return j;
}

Eigen::Matrix3d jacobian_to(const Pose2& from) {
  const double c = std::cos(from.yaw);
  const double s = std::sin(from.yaw);
  Eigen::Matrix3d j;
  j << c, s, 0, -s, c, 0, 0, 0, 1;
  return j;
}

/// Normal equations over the nodes from `first` on.
class Equations {
 public:
  Equations(std::size_t first, std::size_t nodes, const std::vector<Constraint>& constraints)
      : first_(first), blocks_(nodes - first, indices_of(first, constraints)) {}

  /// Before the constraints of an iteration are added, in the order that the constructor saw.
  void reset() {
    constexpr double kTiny = 1e-6;  // keeps a node without constraints where it is
    blocks_.reset(kTiny);
    next_block_ = 0;
  }

  void add(const Constraint& constraint, const Eigen::Matrix3d& j_from, const Eigen::Matrix3d& j_to,
           const Eigen::Vector3d& error, double weight) {
    const Eigen::Matrix3d from_side = weight * j_from.transpose() * constraint.information;
    const Eigen::Matrix3d to_side = weight * j_to.transpose() * constraint.information;
    const bool from_free = constraint.from >= first_;
    const bool to_free = constraint.to >= first_;
    if (from_free) add_own(constraint.from, from_side, j_from, error);
    if (to_free) add_own(constraint.to, to_side, j_to, error);
    if (from_free && to_free) blocks_.add(next_block_++, to_side * j_from);
  }

  /// False when there is no solution.
  [[nodiscard]] bool solve() { return blocks_.solve(); }
  [[nodiscard]] const Eigen::Vector3d& move(std::size_t node) const {
    return blocks_.solution(node - first_);
  }

 private:
  static std::vector<BlockEquations::BlockIndex> indices_of(std::size_t first,
                                                            const std::vector<Constraint>& constraints) {
    std::vector<BlockEquations::BlockIndex> indices;
    for (const Constraint& constraint : constraints)
      if (constraint.from >= first && constraint.to >= first)
        indices.emplace_back(constraint.to - first, constraint.from - first);
    return indices;
  }

  void add_own(std::size_t node, const Eigen::Matrix3d& side, const Eigen::Matrix3d& j,
               const Eigen::Vector3d& error) {
    blocks_.add_diagonal(node - first_, side * j);
    blocks_.add_right_side(node - first_, -side * error);
  }

  std::size_t first_;
  std::size_t next_block_{0};
  BlockEquations blocks_;
};

}  // namespace

Eigen::Vector3d PoseGraph::error(const Constraint& constraint) const {
  const Pose2 seen = between(poses_[constraint.from], poses_[constraint.to]);
  return {seen.x - constraint.from_T_to.x, seen.y - constraint.from_T_to.y,
          wrap_angle(seen.yaw - constraint.from_T_to.yaw)};
}

double PoseGraph::squared_error(const Constraint& constraint) const {
  const Eigen::Vector3d e = error(constraint);
  return e.dot(constraint.information * e);
}

bool PoseGraph::optimize(std::size_t first_free, int iterations) {
  const std::size_t first = std::max<std::size_t>(1, first_free);
  if (first >= poses_.size()) return true;
  const auto before = poses_;
  Equations equations(first, poses_.size(), constraints_);
  for (int i = 0; i < iterations; ++i) {
    equations.reset();
    for (const Constraint& constraint : constraints_) {
      if (constraint.from < first && constraint.to < first) continue;
      const Eigen::Vector3d e = error(constraint);
      const double ratio =
          constraint.is_loop_closure ? e.dot(constraint.information * e) / kDoubtfulSquaredError : 0.0;
      const double weight = 1.0 / ((1.0 + ratio) * (1.0 + ratio));
      equations.add(constraint, jacobian_from(poses_[constraint.from], poses_[constraint.to]),
                    jacobian_to(poses_[constraint.from]), e, weight);
    }
    double largest = 0;
    bool finite = equations.solve();
    for (std::size_t node = first; finite && node < poses_.size(); ++node) {
      const Eigen::Vector3d& move = equations.move(node);
      Pose2& pose = poses_[node];
      pose = {pose.x + move.x(), pose.y + move.y(), wrap_angle(pose.yaw + move.z())};
      largest = std::max(largest, move.cwiseAbs().maxCoeff());
      finite = move.allFinite();
    }
    if (!finite) {
      poses_ = before;
      return false;
    }
    if (largest < kSettledM) break;
  }
  return true;
}

}  // namespace extperfc::mapping
