#include "mapping/relative_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "mapping/rotation_by.hpp"

namespace extperfc::mapping {

namespace {

constexpr double kLeverM = 5.0;              // weighs yaw against position in the order of nodes
constexpr double kSystematicFraction = 0.3;  // of a step's standard deviation that all steps have in common
constexpr double kSigmas = 3.0;

double size_of(const RelativeUncertainty& uncertainty) {
  const Eigen::Matrix3d& c = uncertainty.covariance;
  return c(0, 0) + c(1, 1) + kLeverM * kLeverM * c(2, 2);
}

double systematic_of(const Eigen::Matrix3d& covariance) {
  return kSystematicFraction * std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
}

/// Adds one step's uncertainty to what is known of the node that it begins at. Everything along the same
/// axes.
RelativeUncertainty extend(const RelativeUncertainty& known, double step_x, double step_y,
                           const Eigen::Matrix3d& covariance, double systematic_m) {
  Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
  lever(0, 2) = -step_y;
  lever(1, 2) = step_x;
  RelativeUncertainty sum;
  sum.connected = true;
  sum.covariance = lever * known.covariance * lever.transpose() + covariance;
  sum.systematic_m = known.systematic_m + systematic_m;
  return sum;
}

bool is_usable(const PoseGraph& graph, const Constraint& constraint) {
  return !constraint.is_loop_closure || (!constraint.information.isZero() &&
                                         graph.squared_error(constraint) < PoseGraph::kDoubtfulSquaredError);
}

}  // namespace

double widest_sigma_m(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>(),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues()[1]));
}

double RelativeUncertainty::reach_m() const {
  return kSigmas * widest_sigma_m(covariance) + systematic_m;
}

double RelativeUncertainty::sigma_m() const {
  return widest_sigma_m(with_bias());
}

double RelativeUncertainty::reach_rad() const {
  return kSigmas * std::sqrt(covariance(2, 2));
}

bool RelativeUncertainty::is_unknown() const {
  return !connected || covariance(2, 2) > Constraint::kUnknownRad2;
}

Eigen::Matrix3d RelativeUncertainty::with_bias() const {
  Eigen::Matrix3d sum = covariance;
  const double bias_m = systematic_m / 2;
  sum(0, 0) += bias_m * bias_m;
  sum(1, 1) += bias_m * bias_m;
  return sum;
}

RelativeUncertainty extend(const RelativeUncertainty& from, const PoseGraph& graph,
                           const Constraint& constraint) {
  const Pose2& origin = graph.poses().front();
  const Pose2 at = between(origin, graph.poses()[constraint.from]);
  const Pose2 next = between(origin, graph.poses()[constraint.to]);
  const Eigen::Matrix3d covariance = constraint.covariance();
  const Eigen::Matrix3d to_origin = rotation_by(at.yaw);
  return extend(from, next.x - at.x, next.y - at.y, to_origin * covariance * to_origin.transpose(),
                systematic_of(covariance));
}

RelativeUncertainties::RelativeUncertainties(const PoseGraph& graph)
    : poses_(graph.poses()), first_link_(graph.poses().size() + 1, 0) {
  std::vector<const Constraint*> usable;
  usable.reserve(graph.constraints().size());
  for (const Constraint& constraint : graph.constraints()) {
    if (!is_usable(graph, constraint)) continue;
    usable.push_back(&constraint);
    ++first_link_[constraint.from + 1];
    ++first_link_[constraint.to + 1];
  }
  std::partial_sum(first_link_.begin(), first_link_.end(), first_link_.begin());
  links_.resize(first_link_.back());
  steps_.reserve(usable.size());
  auto next = first_link_;
  for (const Constraint* constraint : usable) {
    links_[next[constraint->from]++] = {steps_.size(), constraint->to};
    links_[next[constraint->to]++] = {steps_.size(), constraint->from};
    const Eigen::Matrix3d covariance = constraint->covariance();
    const Eigen::Matrix3d to_graph = rotation_by(poses_[constraint->from].yaw);
    steps_.push_back({to_graph * covariance * to_graph.transpose(), systematic_of(covariance)});
  }
}

std::vector<RelativeUncertainty> RelativeUncertainties::from(std::size_t node) const {
  std::vector<RelativeUncertainty> known(poses_.size());
  std::vector<bool> settled(known.size(), false);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  known[node].connected = true;
  open.emplace(0.0, node);
  while (!open.empty()) {
    const std::size_t here = open.top().second;
    open.pop();
    if (settled[here]) continue;
    settled[here] = true;
    for (std::size_t l = first_link_[here]; l < first_link_[here + 1]; ++l) {
      const auto& [index, other] = links_[l];
      if (settled[other]) continue;
      const Step& step = steps_[index];
      auto extended = extend(known[here], poses_[other].x - poses_[here].x, poses_[other].y - poses_[here].y,
                             step.covariance, step.systematic_m);
      const double size = size_of(extended);
      if (known[other].connected && size >= size_of(known[other])) continue;
      known[other] = extended;
      open.emplace(size, other);
    }
  }
  const Eigen::Matrix3d to_node = rotation_by(-poses_[node].yaw);
  for (RelativeUncertainty& uncertainty : known)
    uncertainty.covariance = to_node * uncertainty.covariance * to_node.transpose();
  return known;
}

std::vector<RelativeUncertainty> relative_uncertainty(const PoseGraph& graph, std::size_t from) {
  return RelativeUncertainties(graph).from(from);
}

}  // namespace extperfc::mapping
