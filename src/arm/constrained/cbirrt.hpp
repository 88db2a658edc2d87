#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"

#include "arm/constrained/manifold.hpp"
#include "arm/planning/tree.hpp"

namespace extperfc::arm::constrained {

/// A path and the index of the goal at its end.
struct Found {
  States waypoints;
  int goal{-1};
};

/// Two trees on a manifold that grow towards each other, one from the start and one from all goals.
class Cbirrt {
 public:
  /// The start and all goals must be free, within the limits and on the manifold, which must outlive it.
  Cbirrt(Manifold& manifold, double range_rad, int max_states, const JointVector& start, const States& goals);

  /// Nothing when `stop` said so or the trees are full.
  [[nodiscard]] std::optional<Found> grow(Rng& rng, const std::function<bool()>& stop);

  /// In both trees, those within edges counted.
  [[nodiscard]] int states() const { return states_; }

 private:
  struct Side {
    explicit Side(int joints) : tree(joints) {}
    planning::Tree tree;
    std::vector<States> edges;  ///< per node: the states behind its parent, itself the last one
  };
  enum class Step { kBlocked, kAdvanced, kReached };

  void add_root(Side* side, const JointVector& state);
  Step extend(Side* side, int from, const JointVector& target, const std::function<bool()>& stop, int* added);
  [[nodiscard]] Found join(int in_start, int in_goals) const;
  [[nodiscard]] bool full() const { return states_ >= max_states_; }

  Manifold& manifold_;
  double range_rad_;
  int max_states_;
  Side from_start_, from_goals_;
  int states_{0};
  bool grows_start_{true};
};

}  // namespace extperfc::arm::constrained
