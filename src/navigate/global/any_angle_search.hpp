#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "navigate/global/bucket_queue.hpp"
#include "navigate/global/tile_pool.hpp"

namespace extperfc::navigate {

enum class SearchStatus { kSettled, kExhausted, kInterrupted };

/// A* in which a node's parent may be any node that it sees (Theta*, Nash et al. 2007), in a variant for
/// cells of different cost: a node is reached over its neighbour, and when it is expanded the straight line
/// from the neighbour's parent replaces this where it costs no more. One line per expanded node. A settled
/// node is not expanded again. Resumes where it stopped.
template <typename Space>
class AnyAngleSearch {
 public:
  /// `origin`: a point in `node`, which is admissible. `first_key`: a lower bound of all keys. Lines are no
  /// longer than max_line.
  void begin(Space& space, std::int32_t node, const Eigen::Vector2d& origin, float first_key,
             double max_line);

  /// Expands until `target` is settled. `estimate(node)`: path cost from there to where the search leads,
  /// infinite where that is impossible; `interrupted()` is asked every 1024 nodes.
  template <typename Estimate, typename Interrupted>
  SearchStatus settle(std::int32_t target, Estimate& estimate, Interrupted& interrupted);

  [[nodiscard]] Eigen::Vector2d position(std::int32_t node) const {
    return node == origin_node_ ? origin_ : Space::middle_of(node);
  }
  /// From the origin to a settled node: the origin first, the middle of the node last.
  [[nodiscard]] std::vector<Eigen::Vector2d> path_to(std::int32_t node);
  [[nodiscard]] std::size_t expanded() const { return expanded_; }
  [[nodiscard]] std::size_t bytes() const { return queue_.bytes(); }

 private:
  void straighten(std::int32_t node, SearchNode& reached);

  static constexpr float kBucket = 0.25F;  ///< width of the queue's buckets
  static constexpr float kGain = 1e-3F;    ///< smaller improvements of a path cost do not count

  Space* space_{nullptr};
  BucketQueue queue_;
  Eigen::Vector2d origin_{Eigen::Vector2d::Zero()};
  std::int32_t origin_node_{-1};
  double max_line_{0};
  std::size_t expanded_{0};
};

template <typename Space>
void AnyAngleSearch<Space>::begin(Space& space, std::int32_t node, const Eigen::Vector2d& origin,
                                  float first_key, double max_line) {
  space_ = &space;
  origin_ = origin;
  origin_node_ = node;
  max_line_ = max_line;
  expanded_ = 0;
  queue_.clear(first_key, kBucket);
  SearchNode& state = space.state(node);
  state.path_cost = 0;
  state.parent = node;
  queue_.push(first_key, node);
}

template <typename Space>
template <typename Estimate, typename Interrupted>
SearchStatus AnyAngleSearch<Space>::settle(std::int32_t target, Estimate& estimate,
                                           Interrupted& interrupted) {
  const SearchNode& goal = space_->state(target);
  while (!goal.settled) {
    if (queue_.empty()) return SearchStatus::kExhausted;
    const std::int32_t node = queue_.pop().value;
    SearchNode& reached = space_->state(node);
    if (reached.settled) continue;
    reached.settled = true;
    straighten(node, reached);
    space_->for_neighbours(node, [&](std::int32_t next, float step) {
      SearchNode& state = space_->state(next);
      const float cost = reached.path_cost + step;
      if (state.settled || !(cost + kGain < state.path_cost)) return;
      if (state.rest < 0) state.rest = estimate(next);
      if (!std::isfinite(state.rest)) return;
      state.path_cost = cost;
      state.parent = node;
      queue_.push(cost + state.rest, next);
    });
    if (++expanded_ % 1024 == 0 && interrupted()) return SearchStatus::kInterrupted;
  }
  return SearchStatus::kSettled;
}

template <typename Space>
void AnyAngleSearch<Space>::straighten(std::int32_t node, SearchNode& reached) {
  const std::int32_t ancestor = space_->state(reached.parent).parent;
  if (ancestor == reached.parent) return;
  const Eigen::Vector2d from = position(ancestor);
  const Eigen::Vector2d to = position(node);
  if ((to - from).squaredNorm() > max_line_ * max_line_) return;
  const float to_ancestor = space_->state(ancestor).path_cost;
  const double line = space_->line_cost(ancestor, from, node, to,
                                        static_cast<double>(reached.path_cost - to_ancestor + kGain));
  if (!std::isfinite(line)) return;
  reached.path_cost = to_ancestor + static_cast<float>(line);
  reached.parent = ancestor;
}

template <typename Space>
std::vector<Eigen::Vector2d> AnyAngleSearch<Space>::path_to(std::int32_t node) {
  std::vector<Eigen::Vector2d> path{position(node)};
  for (; node != origin_node_; path.push_back(position(node))) node = space_->state(node).parent;
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace extperfc::navigate
