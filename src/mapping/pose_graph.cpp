#include "mapping/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/block_equations.hpp"

namespace extperfc::mapping {

namespace {

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
  Equations(std::size_t first, std::size_t nodes, const std::vector<Relation>& relations)
      : first_(first), blocks_(nodes - first, places_of(first, relations)) {}

  /// Before the relations of an iteration are added, in the order that the constructor saw.
  void reset() {
    constexpr double kTiny = 1e-6;  // keeps a node that nothing holds where it is
    blocks_.reset(kTiny);
    next_place_ = 0;
  }

  void add(const Relation& relation, const Eigen::Matrix3d& j_from, const Eigen::Matrix3d& j_to,
           const Eigen::Vector3d& error, double weight) {
    const Eigen::Matrix3d from_side = weight * j_from.transpose() * relation.information;
    const Eigen::Matrix3d to_side = weight * j_to.transpose() * relation.information;
    const bool from_free = relation.from >= first_;
    const bool to_free = relation.to >= first_;
    if (from_free) add_own(relation.from, from_side, j_from, error);
    if (to_free) add_own(relation.to, to_side, j_to, error);
    if (from_free && to_free) blocks_.add(next_place_++, to_side * j_from);
  }

  /// False when there is no solution.
  [[nodiscard]] bool solve() { return blocks_.solve(); }
  [[nodiscard]] const Eigen::Vector3d& move(std::size_t node) const {
    return blocks_.solution(node - first_);
  }

 private:
  static std::vector<BlockEquations::Place> places_of(std::size_t first,
                                                      const std::vector<Relation>& relations) {
    std::vector<BlockEquations::Place> places;
    for (const Relation& relation : relations)
      if (relation.from >= first && relation.to >= first)
        places.emplace_back(relation.to - first, relation.from - first);
    return places;
  }

  void add_own(std::size_t node, const Eigen::Matrix3d& side, const Eigen::Matrix3d& j,
               const Eigen::Vector3d& error) {
    blocks_.add_diagonal(node - first_, side * j);
    blocks_.add_right_side(node - first_, -side * error);
  }

  std::size_t first_;
  std::size_t next_place_{0};
  BlockEquations blocks_;
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
  Equations equations(first, poses_.size(), relations_);
  for (int i = 0; i < iterations; ++i) {
    equations.reset();
    for (const Relation& relation : relations_) {
      if (relation.from < first && relation.to < first) continue;
      const Eigen::Vector3d e = error(relation);
      const double ratio = relation.sighting ? e.dot(relation.information * e) / kDoubtfulSquaredError : 0.0;
      const double weight = 1.0 / ((1.0 + ratio) * (1.0 + ratio));
      equations.add(relation, jacobian_from(poses_[relation.from], poses_[relation.to]),
                    jacobian_to(poses_[relation.from]), e, weight);
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
