#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"

#include "arm/planning/tree.hpp"

namespace extperfc::arm {

/// A path and the index of the goal at its end.
struct Found {
  std::vector<JointVector> waypoints;
  int goal{-1};
};

/// Two trees that grow towards each other, one from the start and one from all goals. What a sample is, and
/// what an edge, is up to those that derive from it.
class TwoTrees {
 public:
  virtual ~TwoTrees() = default;

  /// Draws at most `samples` samples; nothing when the trees did not meet, `stop` said so, or the trees are
  /// full. Goes on where the last call ended.
  [[nodiscard]] std::optional<Found> grow(int samples, Rng& rng, const std::function<bool()>& stop);

  /// In both trees, those within edges counted.
  [[nodiscard]] int states() const { return from_start_.states() + from_goals_.states(); }
  [[nodiscard]] bool full() const { return states() >= max_states_; }

 protected:
  enum class Step { kBlocked, kAdvanced, kReached };

  TwoTrees(int max_states, const JointVector& start, const std::vector<JointVector>& goals);

  [[nodiscard]] const JointVector& start() const { return from_start_.state(0); }
  [[nodiscard]] virtual std::optional<JointVector> sample(Rng& rng) = 0;
  /// Adds a proven edge from node `from` towards `target`; `added` is the node at its end.
  virtual Step extend(Tree& tree, int from, const JointVector& target, const std::function<bool()>& stop,
                      int* added) = 0;

 private:
  void choose_tree();
  [[nodiscard]] Found join(int grown, int other) const;

  int max_states_;
  Tree from_start_, from_goals_;
  bool grows_start_{true};
};

}  // namespace extperfc::arm
