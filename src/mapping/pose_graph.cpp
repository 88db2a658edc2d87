#include "mapping/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>

namespace extperfc::mapping {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

// A sighting that is off by this chi-square pulls with a quarter of its weight (Geman-McClure).
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
  Equations(std::size_t first, std::size_t nodes)
      : first_(first),
        size_(static_cast<Eigen::Index>(3 * (nodes - first))),
        g_(Eigen::VectorXd::Zero(size_)) {}

  void add(const Relation& relation, const Eigen::Matrix3d& j_from, const Eigen::Matrix3d& j_to,
           const Eigen::Vector3d& error, double weight) {
    const Eigen::Matrix3d information = weight * relation.information;
    const bool from_free = relation.from >= first_;
    const bool to_free = relation.to >= first_;
    if (from_free) add_own(relation.from, j_from, information, error);
    if (to_free) add_own(relation.to, j_to, information, error);
    if (from_free && to_free) {
      // The lower triangle alone is read.
      const bool later = relation.to > relation.from;
      const Eigen::Matrix3d block =
          later ? j_to.transpose() * information * j_from : j_from.transpose() * information * j_to;
      add_block(later ? relation.to : relation.from, later ? relation.from : relation.to, block);
    }
  }

  /// False when there is no solution.
  bool solve(Eigen::VectorXd& move) {
    constexpr double kTiny = 1e-6;  // keeps a node that nothing holds where it is
    for (Eigen::Index i = 0; i < size_; ++i) entries_.emplace_back(i, i, kTiny);
    Sparse h(size_, size_);
    h.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Sparse, Eigen::Lower> solver(h);
    if (solver.info() != Eigen::Success) return false;
    move = -solver.solve(g_);
    return move.allFinite();
  }

 private:
  [[nodiscard]] Eigen::Index row(std::size_t node) const {
    return static_cast<Eigen::Index>(3 * (node - first_));
  }

  void add_own(std::size_t node, const Eigen::Matrix3d& j, const Eigen::Matrix3d& information,
               const Eigen::Vector3d& error) {
    add_block(node, node, j.transpose() * information * j);
    g_.segment<3>(row(node)) += j.transpose() * information * error;
  }

  void add_block(std::size_t row_node, std::size_t column_node, const Eigen::Matrix3d& block) {
    for (Eigen::Index r = 0; r < 3; ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        entries_.emplace_back(row(row_node) + r, row(column_node) + c, block(r, c));
  }

  std::size_t first_;
  Eigen::Index size_;
  Eigen::VectorXd g_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

Eigen::Vector3d PoseGraph::error(const Relation& relation) const {
  const Pose2 seen = between(poses_[relation.from], poses_[relation.to]);
  return {seen.x - relation.from_T_to.x, seen.y - relation.from_T_to.y,
          wrap_angle(seen.yaw - relation.from_T_to.yaw)};
}

double PoseGraph::squared_error(const Relation& relation) const {
  const Eigen::Vector3d e = error(relation);
  return e.dot(relation.information * e);
}

bool PoseGraph::relax(std::size_t first_free, int iterations) {
  const std::size_t first = std::max<std::size_t>(1, first_free);
  if (first >= poses_.size()) return true;
  const auto before = poses_;
  for (int i = 0; i < iterations; ++i) {
    Equations equations(first, poses_.size());
    for (const Relation& relation : relations_) {
      if (relation.from < first && relation.to < first) continue;
      const Eigen::Vector3d e = error(relation);
      const double ratio = relation.sighting ? e.dot(relation.information * e) / kDoubtfulSquaredError : 0.0;
      const double weight = 1.0 / ((1.0 + ratio) * (1.0 + ratio));
      equations.add(relation, jacobian_from(poses_[relation.from], poses_[relation.to]),
                    jacobian_to(poses_[relation.from]), e, weight);
    }
    Eigen::VectorXd move;
    if (!equations.solve(move)) {
      poses_ = before;
      return false;
    }
    for (std::size_t node = first; node < poses_.size(); ++node) {
      const auto at = static_cast<Eigen::Index>(3 * (node - first));
      Pose2& pose = poses_[node];
      pose = {pose.x + move[at], pose.y + move[at + 1], wrap_angle(pose.yaw + move[at + 2])};
    }
    if (move.cwiseAbs().maxCoeff() < kSettledM) break;
  }
  return true;
}

}  // namespace extperfc::mapping
