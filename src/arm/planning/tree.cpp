#include "arm/planning/tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace extperfc::arm {

namespace {

constexpr Eigen::Index kFirstRoom = 256;
// Values of the paper's kind: a domain is unbounded until an extension from its state fails.
constexpr double kFirstDomainRad = 4.0;
constexpr double kMinDomainRad = 1.0;
constexpr double kDomainStep = 1e-4;

}  // namespace

Tree::Tree(int joints) : columns_(kFirstRoom, joints), squares_(kFirstRoom) {}

int Tree::add(const JointVector& state, int parent, std::vector<JointVector> edge) {
  const Eigen::Index row = size();
  if (row == columns_.rows()) {
    columns_.conservativeResize(2 * columns_.rows(), Eigen::NoChange);
    squares_.resize(columns_.rows());
  }
  columns_.row(row) = state.cast<float>().transpose().array();
  states_.push_back(state);
  parents_.push_back(parent);
  on_edges_ += static_cast<int>(edge.size());
  edges_.push_back(std::move(edge));
  domains_.push_back(std::numeric_limits<double>::infinity());
  return static_cast<int>(row);
}

Tree::Nearest Tree::nearest(const JointVector& state) {
  const Eigen::Index rows = size();
  auto squares = squares_.head(rows);
  squares = (columns_.col(0).head(rows) - static_cast<float>(state[0])).square();
  for (Eigen::Index j = 1; j < state.size(); ++j)
    squares += (columns_.col(j).head(rows) - static_cast<float>(state[j])).square();
  Eigen::Index index = 0;
  squares.minCoeff(&index);
  const int nearest = static_cast<int>(index);
  return {nearest, (states_[nearest] - state).norm()};
}

std::vector<JointVector> Tree::branch(int index) const {
  std::vector<JointVector> result;
  for (; index >= 0; index = parents_[index]) {
    result.push_back(states_[index]);
    result.insert(result.end(), edges_[index].rbegin(), edges_[index].rend());
  }
  std::reverse(result.begin(), result.end());
  return result;
}

void Tree::widen_domain(int index) {
  if (std::isfinite(domains_[index])) domains_[index] *= 1.0 + kDomainStep;
}

void Tree::narrow_domain(int index) {
  domains_[index] = std::isfinite(domains_[index])
                        ? std::max(kMinDomainRad, domains_[index] * (1.0 - kDomainStep))
                        : kFirstDomainRad;
}

}  // namespace extperfc::arm
