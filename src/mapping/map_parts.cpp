#include "mapping/map_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace extperfc::mapping {

namespace {

constexpr double kUnknownM = 100.0;
constexpr double kUnknownRad = M_PI;
constexpr double kBesideM = 30.0;  // between key frames of two parts: more than most scanners see

/// Sets of nodes that constraints join (union-find).
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  std::size_t root(std::size_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  /// The smaller root stays.
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

bool joins(const PoseGraph& graph, const Constraint& constraint) {
  if (!constraint.is_loop_closure) return !constraint.is_unknown();
  return !constraint.information.isZero() &&
         graph.squared_error(constraint) < PoseGraph::kDoubtfulSquaredError;
}

/// Unknown steps follow the poses of their nodes.
void follow_poses(PoseGraph& graph) {
  for (Constraint& constraint : graph.constraints())
    if (constraint.is_unknown())
      constraint.from_T_to = between(graph.poses()[constraint.from], graph.poses()[constraint.to]);
}

}  // namespace

Constraint unknown_step(std::size_t from, const Pose2& from_T_to) {
  const Eigen::Vector3d information(1 / (kUnknownM * kUnknownM), 1 / (kUnknownM * kUnknownM),
                                    1 / (kUnknownRad * kUnknownRad));
  return {from, from + 1, from_T_to, information.asDiagonal().toDenseMatrix(), false};
}

std::vector<std::size_t> parts_of(const PoseGraph& graph) {
  const std::size_t nodes = graph.poses().size();
  Sets sets(nodes);
  for (const Constraint& constraint : graph.constraints())
    if (joins(graph, constraint)) sets.join(constraint.from, constraint.to);
  std::vector<std::size_t> parts(nodes);
  std::size_t count = 0;
  for (std::size_t i = 0; i < nodes; ++i) parts[i] = sets.root(i) == i ? count++ : parts[sets.root(i)];
  return parts;
}

std::size_t count_parts(const PoseGraph& graph) {
  const auto parts = parts_of(graph);
  return parts.empty() ? 0 : *std::max_element(parts.begin(), parts.end()) + 1;
}

Pose2 pose_beside(const PoseGraph& graph) {
  double right = -std::numeric_limits<double>::infinity();
  for (const Pose2& pose : graph.poses()) right = std::max(right, pose.x);
  return {right + kBesideM, graph.poses().back().y, graph.poses().back().yaw};
}

void set_parts_apart(PoseGraph& graph) {
  const auto parts = parts_of(graph);
  const std::size_t count = count_parts(graph);
  if (count < 2) return;
  auto poses = graph.poses();
  double right = -std::numeric_limits<double>::infinity();
  for (std::size_t part = 0; part < count; ++part) {
    double left = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < poses.size(); ++i)
      if (parts[i] == part) left = std::min(left, poses[i].x);
    const double shift_m = part == 0 ? 0.0 : right + kBesideM - left;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (parts[i] != part) continue;
      poses[i].x += shift_m;
      right = std::max(right, poses[i].x);
    }
  }
  graph.set_poses(std::move(poses));
  follow_poses(graph);
}

void bring_together(PoseGraph& graph, const Constraint& closure) {
  const auto parts = parts_of(graph);
  if (parts[closure.from] == parts[closure.to]) return;
  auto poses = graph.poses();
  const Pose2 moved = compose(compose(poses[closure.from], closure.from_T_to), inverse(poses[closure.to]));
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (parts[i] == parts[closure.to]) poses[i] = compose(moved, poses[i]);
  graph.set_poses(std::move(poses));
  follow_poses(graph);
}

}  // namespace extperfc::mapping
