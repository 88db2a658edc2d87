#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::arm {

/// States with their parents, and the nearest of them to a given state.
class Tree {
 public:
  explicit Tree(int joints);

  /// `parent` is -1 for a root; `edge`: states on the edge from it, both ends left out. Returns the index of
  /// the new state. Amortised O(joints).
  int add(const JointVector& state, int parent, std::vector<JointVector> edge = {});

  [[nodiscard]] int size() const { return static_cast<int>(states_.size()); }
  /// Those on edges counted.
  [[nodiscard]] int states() const { return size() + on_edges_; }
  [[nodiscard]] const JointVector& state(int index) const { return states_[index]; }
  [[nodiscard]] int parent(int index) const { return parents_[index]; }

  struct Nearest {
    int index{-1};
    double distance_rad{0};
  };
  /// By Euclidean distance, in single precision; the tree must not be empty. O(size).
  [[nodiscard]] Nearest nearest(const JointVector& state);

  /// States from the root of `index` to `index`, those on edges included.
  [[nodiscard]] std::vector<JointVector> branch(int index) const;

  /// Samples farther than this from a state are not drawn towards it [rad].
  [[nodiscard]] double domain_rad(int index) const { return domains_[index]; }
  void widen_domain(int index);
  void narrow_domain(int index);

 private:
  std::vector<JointVector> states_;
  std::vector<int> parents_;
  std::vector<std::vector<JointVector>> edges_;
  int on_edges_{0};
  std::vector<double> domains_;
  Eigen::ArrayXXf columns_;  ///< one row per state (with room for more), one column per joint
  Eigen::ArrayXf squares_;   ///< scratch of nearest()
};

}  // namespace extperfc::arm
