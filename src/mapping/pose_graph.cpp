#include "mapping/pose_graph.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace extperfc::mapping {

namespace {

constexpr double kSettledM = 1e-5;

// A tracked step with a chi-square beyond this slipped: its residual counts linearly.
constexpr double kSlippedSquaredError = 25.0;

/// Weight of a squared error under the Geman-McClure loss: one fourth at `scale`.
double geman_mcclure(double squared_error, double scale) {
  const double root = 1.0 / (1.0 + squared_error / scale);
  return root * root;
}

/// Weight of a squared error under the Huber loss that is linear beyond `scale`.
double huber(double squared_error, double scale) {
  return squared_error <= scale ? 1.0 : std::sqrt(scale / squared_error);
}

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

/// Normal equations over the nodes from `first` on; order and pattern of the factor are found once.
class Equations {
 public:
  Equations(std::size_t first, std::size_t nodes)
      : first_(first),
        right_side_(3 * static_cast<Eigen::Index>(nodes - first)),
        matrix_(right_side_.size(), right_side_.size()) {}

  void reset() {
    constexpr double kTiny = 1e-6;  // keeps a node without constraints where it is
    cells_.clear();
    for (int i = 0; i < static_cast<int>(right_side_.size()); ++i) cells_.emplace_back(i, i, kTiny);
    right_side_.setZero();
  }

  void add(const Constraint& constraint, const Eigen::Matrix3d& j_from, const Eigen::Matrix3d& j_to,
           const Eigen::Vector3d& error, double weight) {
    const Eigen::Matrix3d from_side = weight * j_from.transpose() * constraint.information;
    const Eigen::Matrix3d to_side = weight * j_to.transpose() * constraint.information;
    const bool from_free = constraint.from >= first_;
    const bool to_free = constraint.to >= first_;
    if (from_free) add_own(constraint.from, from_side, j_from, error);
    if (to_free) add_own(constraint.to, to_side, j_to, error);
    if (!from_free || !to_free) return;
    const Eigen::Matrix3d block = to_side * j_from;
    if (constraint.to > constraint.from)
      add_block(constraint.to, constraint.from, block);
    else
      add_block(constraint.from, constraint.to, block.transpose());
  }

  /// False when there is no solution.
  [[nodiscard]] bool solve() {
    matrix_.setFromTriplets(cells_.begin(), cells_.end());
    if (!analysed_) solver_.analyzePattern(matrix_);
    analysed_ = true;
    solver_.factorize(matrix_);
    if (solver_.info() != Eigen::Success) return false;
    right_side_ = solver_.solve(right_side_).eval();
    return true;
  }
  [[nodiscard]] Eigen::Vector3d move(std::size_t node) const { return right_side_.segment<3>(row_of(node)); }

 private:
  [[nodiscard]] Eigen::Index row_of(std::size_t node) const {
    return 3 * static_cast<Eigen::Index>(node - first_);
  }

  void add_block(std::size_t row, std::size_t column, const Eigen::Matrix3d& block) {
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r)
        cells_.emplace_back(static_cast<int>(row_of(row)) + r, static_cast<int>(row_of(column)) + c,
                            block(r, c));
  }

  void add_own(std::size_t node, const Eigen::Matrix3d& side, const Eigen::Matrix3d& j,
               const Eigen::Vector3d& error) {
    add_block(node, node, side * j);
    right_side_.segment<3>(row_of(node)) -= side * error;
  }

  std::size_t first_;
  bool analysed_{false};
  Eigen::VectorXd right_side_;  // the solution, after solve()
  std::vector<Eigen::Triplet<double>> cells_;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> solver_;
};

}  // namespace

Eigen::Matrix3d Constraint::covariance() const {
  return (information + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
}

bool Constraint::is_unknown() const {
  return !is_loop_closure && information(2, 2) < 1 / kUnknownRad2;
}

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
  return optimize(first_free, iterations, kDoubtfulSquaredError);
}

bool PoseGraph::optimize_gradually() {
  constexpr int kLastIterations = 6;
  constexpr double kEasing = 8.0;
  constexpr double kFarOff = 1e5;  // beyond, a loop closure counts in full whatever its residual is
  const auto before = poses_;
  double largest = kDoubtfulSquaredError;
  for (const Constraint& constraint : constraints_)
    if (constraint.is_loop_closure) largest = std::max(largest, squared_error(constraint));
  for (double scale = std::min(largest, kFarOff) * kEasing; scale > kDoubtfulSquaredError; scale /= kEasing) {
    if (optimize(0, 2, scale)) continue;
    poses_ = before;
    return false;
  }
  if (optimize(0, kLastIterations, kDoubtfulSquaredError)) return true;
  poses_ = before;
  return false;
}

bool PoseGraph::optimize(std::size_t first_free, int iterations, double loss_scale) {
  const std::size_t first = std::max<std::size_t>(1, first_free);
  if (first >= poses_.size()) return true;
  const auto before = poses_;
  Equations equations(first, poses_.size());
  for (int i = 0; i < iterations; ++i) {
    equations.reset();
    for (const Constraint& constraint : constraints_) {
      if (constraint.from < first && constraint.to < first) continue;
      const Eigen::Vector3d e = error(constraint);
      const double squared = e.dot(constraint.information * e);
      const double weight = constraint.is_loop_closure ? geman_mcclure(squared, loss_scale)
                                                       : huber(squared, kSlippedSquaredError);
      equations.add(constraint, jacobian_from(poses_[constraint.from], poses_[constraint.to]),
                    jacobian_to(poses_[constraint.from]), e, weight);
    }
    double largest = 0;
    bool finite = equations.solve();
    for (std::size_t node = first; finite && node < poses_.size(); ++node) {
      const Eigen::Vector3d move = equations.move(node);
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
