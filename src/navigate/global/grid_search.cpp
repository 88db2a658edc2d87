#include "navigate/global/grid_search.hpp"

#include <cmath>
#include <limits>

namespace extperfc::navigate {

namespace {

constexpr int kBlock_cells = 4;
constexpr int kBeside_blocks = 3;  // of the path over blocks, where the path over cells is looked for first
constexpr double kMaxLine_cells = 200;
/// Multiplies the estimate of the rest, so that of paths of almost the same cost the search follows one.
/// Blocks weigh their mean, so the estimate may be too large and the path's cost is not bounded by this
/// factor.
constexpr double kCellGreed = 1.02;
/// The same for the search over blocks, of the straight line to the start at the weight of free cells: in
/// buildings, where paths go round corners and beside walls, that is still less than what they cost.
constexpr double kBlockGreed = 1.1;

Cell cell_under(const Eigen::Vector2d& point) {
  return {static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y()))};
}

/// Marks the blocks beside a path over them.
void mark_beside(BlockSpace& blocks, const Polyline& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int steps = std::max(1, static_cast<int>(std::ceil((path[i] - path[i - 1]).norm())));
    for (int k = 0; k <= steps; ++k)
      blocks.mark_near(path[i - 1] + (path[i] - path[i - 1]) * k / steps, kBeside_blocks);
  }
}

/// Path cost from a cell to the goal: straight to where its own block's path comes from.
class BlockEstimate {
 public:
  BlockEstimate(BlockSpace& blocks, AnyAngleSearch<BlockSpace>& search, const Eigen::Vector2d& start,
                const PlanClock& clock)
      : blocks_(blocks), search_(search), start_(start / blocks.block_cells()), clock_(clock) {}

  /// [cells]; infinite where the goal cannot be reached.
  float operator()(std::int32_t cell) {
    const auto block = blocks_.node_of({CellSpace::column_of(cell), CellSpace::row_of(cell)});
    if (block < 0 || (only_marked_ && !blocks_.state(block).near_path) || !settle(block))
      return std::numeric_limits<float>::infinity();
    const SearchNode& reached = blocks_.state(block);
    const double rest = static_cast<double>(blocks_.state(reached.parent).path_cost);
    const Eigen::Vector2d from = search_.position(reached.parent);
    const Eigen::Vector2d here = CellSpace::middle_of(cell) / blocks_.block_cells();
    const double span = (BlockSpace::middle_of(block) - from).norm();
    const double weight = span > 0 ? (static_cast<double>(reached.path_cost) - rest) / span : 1.0;
    return static_cast<float>(kCellGreed * blocks_.block_cells() * (rest + weight * (here - from).norm()));
  }

  [[nodiscard]] bool interrupted() const { return interrupted_; }
  /// Infinite where blocks are not marked.
  void set_only_marked(bool only_marked) { only_marked_ = only_marked; }

 private:
  bool settle(std::int32_t block) {
    const auto straight = [this](std::int32_t node) {
      return static_cast<float>(kBlockGreed * (BlockSpace::middle_of(node) - start_).norm());
    };
    const auto stop = [this] { return clock_.ended().has_value(); };
    const SearchStatus status = search_.settle(block, straight, stop);
    interrupted_ = interrupted_ || status == SearchStatus::kInterrupted;
    return status == SearchStatus::kSettled;
  }

  BlockSpace& blocks_;
  AnyAngleSearch<BlockSpace>& search_;
  Eigen::Vector2d start_;
  const PlanClock& clock_;
  bool interrupted_{false};
  bool only_marked_{false};
};

}  // namespace

GridSearch::Status GridSearch::find(const CostGrid& costs, const Traversal& traversal,
                                    const Eigen::Vector2d& start, const Eigen::Vector2d& goal,
                                    const PlanClock& clock) {
  cells_.begin(costs, traversal);
  blocks_.begin(costs, traversal, kBlock_cells);
  const Cell from = cell_under(start);
  const Cell to = cell_under(goal);
  if (cells_.weight(from.column, from.row) == 0 || cells_.weight(to.column, to.row) == 0)
    return Status::kNoPath;
  const auto direct = static_cast<float>(kBlockGreed * (goal - start).norm() / kBlock_cells);
  coarse_.begin(blocks_, blocks_.node_of(to), goal / kBlock_cells, direct, kMaxLine_cells / kBlock_cells);
  BlockEstimate estimate(blocks_, coarse_, start, clock);
  const std::int32_t source = CellSpace::node_of(from.column, from.row);
  const std::int32_t target = CellSpace::node_of(to.column, to.row);
  const float first = estimate(source);
  if (estimate.interrupted()) return Status::kInterrupted;
  if (!std::isfinite(first)) return Status::kNoPath;
  mark_beside(blocks_, coarse_.path_to(blocks_.node_of(from)));
  const auto stop = [&] { return clock.ended().has_value() || estimate.interrupted(); };
  SearchStatus status{};
  for (const bool only_marked : {true, false}) {
    if (!only_marked) cells_.begin(costs, traversal);
    fine_.begin(cells_, source, start, first, kMaxLine_cells);
    estimate.set_only_marked(only_marked);
    status = fine_.settle(target, estimate, stop);
    if (status != SearchStatus::kExhausted) break;
  }
  if (status == SearchStatus::kInterrupted || estimate.interrupted()) return Status::kInterrupted;
  if (status == SearchStatus::kExhausted) return Status::kNoPath;
  path_ = fine_.path_to(target);
  path_.back() = goal;
  return Status::kFound;
}

}  // namespace extperfc::navigate
