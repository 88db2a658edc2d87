#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace extperfc::mapping {

/// A symmetric positive definite system A x = b that is sparse and whose unknowns come in threes, as poses of
/// a plane do. Made once for a pattern, then filled and solved as often as wanted: order (minimum degree) and
/// pattern of the factor are found once. LDL^T by blocks, row by row (Davis, Direct Methods for Sparse Linear
/// Systems, 2006, section 4.8).
class BlockEquations {
 public:
  using Block = Eigen::Matrix3d;
  /// Row and column of a block, [0, nodes).
  using BlockIndex = std::pair<std::size_t, std::size_t>;

  /// `indices`: the off-diagonal blocks that may be added to, on either side of the diagonal, in any order;
  /// repetitions are allowed.
  BlockEquations(std::size_t nodes, const std::vector<BlockIndex>& indices);

  /// Zero everywhere, but for `diagonal` on the diagonal.
  void reset(double diagonal);
  void add_diagonal(std::size_t node, const Block& block) { diagonal_[position_[node]] += block; }
  /// Adds to the block at indices[index], and its transpose to the mirrored block.
  void add(std::size_t index, const Block& block);
  void add_right_side(std::size_t node, const Eigen::Vector3d& b) { x_[position_[node]] += b; }

  /// Solves; what was added is used up. False when the matrix is not positive definite.
  [[nodiscard]] bool solve();
  /// Of x, after solve().
  [[nodiscard]] const Eigen::Vector3d& solution(std::size_t node) const { return x_[position_[node]]; }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  /// A block of A left of the diagonal.
  struct Entry {
    std::size_t column{0};
    Block block;
  };
  struct Slot {
    std::size_t entry{kNone};  ///< none: on the diagonal
    std::size_t row{0};
    bool mirrored{false};
  };

  void find_order(const std::vector<BlockIndex>& indices);
  void find_entries(const std::vector<BlockIndex>& indices);
  void find_pattern();
  /// Columns of row `row` of the factor, every one before its parent; from `reach_` at the returned index on.
  std::size_t find_reach(std::size_t row);
  [[nodiscard]] bool factorise_row(std::size_t row);
  void substitute();

  // Everything but `slots_` is in the order of elimination.
  std::size_t size_;
  std::vector<std::size_t> position_;     ///< of each node
  std::vector<Slot> slots_;               ///< of each of the constructor's indices
  std::vector<std::size_t> first_entry_;  ///< of each row, and the end
  std::vector<Entry> entries_;
  std::vector<Block> diagonal_;
  std::vector<Eigen::Vector3d> x_;  ///< b until solve()
  // The factor, column by column.
  std::vector<std::size_t> parent_;       ///< in the elimination tree
  std::vector<std::size_t> first_below_;  ///< of each column, and the end
  std::vector<std::size_t> filled_;       ///< end of what is filled of each column
  std::vector<std::size_t> below_row_;
  std::vector<Block> below_;
  std::vector<Eigen::LLT<Block>> pivots_;
  // Of the row in work.
  std::vector<Block> work_;
  std::vector<std::size_t> reach_;
  std::vector<std::size_t> marked_by_;
};

}  // namespace extperfc::mapping
