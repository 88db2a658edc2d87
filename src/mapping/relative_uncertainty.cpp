#include "mapping/relative_uncertainty.hpp"

#include <cmath>
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

/// A constraint as seen from one of its nodes.
struct Link {
  std::size_t constraint;
  std::size_t other;
};

/// Links of node n: [first[n], first[n + 1]).
struct Links {
  explicit Links(const PoseGraph& graph) : first(graph.poses().size() + 1, 0) {
    const auto& constraints = graph.constraints();
    std::vector<bool> usable;
    usable.reserve(constraints.size());
    for (const Constraint& constraint : constraints) {
      usable.push_back(!constraint.is_loop_closure ||
                       graph.squared_error(constraint) < PoseGraph::kDoubtfulSquaredError);
      if (constraint.is_loop_closure && constraint.information.isZero()) usable.back() = false;
      if (!usable.back()) continue;
      ++first[constraint.from + 1];
      ++first[constraint.to + 1];
    }
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    links.resize(first.back());
    auto next = first;
    for (std::size_t i = 0; i < constraints.size(); ++i) {
      if (!usable[i]) continue;
      links[next[constraints[i].from]++] = {i, constraints[i].to};
      links[next[constraints[i].to]++] = {i, constraints[i].from};
    }
  }
  std::vector<std::size_t> first;
  std::vector<Link> links;
};

double size_of(const RelativeUncertainty& uncertainty) {
  const Eigen::Matrix3d& c = uncertainty.covariance;
  return c(0, 0) + c(1, 1) + kLeverM * kLeverM * c(2, 2);
}

/// Adds the uncertainty of one constraint. Poses are seen from the first node of the chain.
RelativeUncertainty extend(const RelativeUncertainty& known, const Pose2& at, const Pose2& next,
                           const Eigen::Matrix3d& covariance, double yaw_of_from) {
  Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
  lever(0, 2) = -(next.y - at.y);
  lever(1, 2) = next.x - at.x;
  const Eigen::Matrix3d to_origin = rotation_by(yaw_of_from);
  RelativeUncertainty sum;
  sum.connected = true;
  sum.covariance =
      lever * known.covariance * lever.transpose() + to_origin * covariance * to_origin.transpose();
  sum.systematic_m =
      known.systematic_m + kSystematicFraction * std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
  return sum;
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
  return extend(from, between(origin, graph.poses()[constraint.from]),
                between(origin, graph.poses()[constraint.to]), constraint.covariance(),
                wrap_angle(graph.poses()[constraint.from].yaw - origin.yaw));
}

std::vector<RelativeUncertainty> relative_uncertainty(const PoseGraph& graph, std::size_t from) {
  const Links links(graph);
  std::vector<RelativeUncertainty> known(graph.poses().size());
  std::vector<bool> settled(known.size(), false);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  known[from].connected = true;
  open.emplace(0.0, from);
  const Pose2& origin = graph.poses()[from];
  while (!open.empty()) {
    const std::size_t node = open.top().second;
    open.pop();
    if (settled[node]) continue;
    settled[node] = true;
    const Pose2 at = between(origin, graph.poses()[node]);
    for (std::size_t l = links.first[node]; l < links.first[node + 1]; ++l) {
      const auto& [index, other] = links.links[l];
      if (settled[other]) continue;
      const Constraint& constraint = graph.constraints()[index];
      const double yaw = wrap_angle(graph.poses()[constraint.from].yaw - origin.yaw);
      auto extended =
          extend(known[node], at, between(origin, graph.poses()[other]), constraint.covariance(), yaw);
      const double size = size_of(extended);
      if (known[other].connected && size >= size_of(known[other])) continue;
      known[other] = extended;
      open.emplace(size, other);
    }
  }
  return known;
}

}  // namespace extperfc::mapping
