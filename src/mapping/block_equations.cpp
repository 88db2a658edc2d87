#include "mapping/block_equations.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace extperfc::mapping {

BlockEquations::BlockEquations(std::size_t nodes, const std::vector<BlockIndex>& indices)
    : size_(nodes),
      position_(nodes),
      diagonal_(nodes),
      x_(nodes),
      parent_(nodes, kNone),
      filled_(nodes),
      pivots_(nodes),
      work_(nodes, Block::Zero()),
      reach_(nodes),
      marked_by_(nodes, kNone) {
  find_order(indices);
  find_entries(indices);
  find_pattern();
  reset(0);
}

/// The pattern of nodes is a ninth of the pattern of unknowns, and gives an order as good.
void BlockEquations::find_order(const std::vector<BlockIndex>& indices) {
  using Pattern = Eigen::SparseMatrix<double>;
  std::vector<Eigen::Triplet<double>> cells;
  cells.reserve(indices.size() + size_);
  for (const auto& [row, column] : indices)
    cells.emplace_back(static_cast<int>(std::max(row, column)), static_cast<int>(std::min(row, column)), 1.0);
  for (std::size_t i = 0; i < size_; ++i) cells.emplace_back(static_cast<int>(i), static_cast<int>(i), 1.0);
  const auto side = static_cast<Eigen::Index>(size_);
  Pattern pattern(side, side);
  pattern.setFromTriplets(cells.begin(), cells.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), order);
  for (Eigen::Index i = 0; i < order.size(); ++i)
    position_[static_cast<std::size_t>(order.indices()[i])] = static_cast<std::size_t>(i);
}

void BlockEquations::find_entries(const std::vector<BlockIndex>& indices) {
  slots_.resize(indices.size());
  const auto left = [&](std::size_t index) {  // row and column, by position
    const auto [lower, upper] =
        std::minmax(position_[indices[index].first], position_[indices[index].second]);
    return BlockIndex(upper, lower);
  };
  std::vector<std::size_t> sorted(indices.size());
  std::iota(sorted.begin(), sorted.end(), std::size_t{0});
  std::sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return left(a) < left(b); });
  first_entry_.assign(size_ + 1, 0);
  BlockIndex last(kNone, kNone);
  for (const std::size_t index : sorted) {
    const BlockIndex at = left(index);
    Slot& slot = slots_[index];
    slot.row = at.first;
    slot.mirrored = position_[indices[index].first] != at.first;
    if (at.first == at.second) continue;
    if (at != last) {
      entries_.push_back({at.second, Block::Zero()});
      ++first_entry_[at.first + 1];
    }
    last = at;
    slot.entry = entries_.size() - 1;
  }
  std::partial_sum(first_entry_.begin(), first_entry_.end(), first_entry_.begin());
}

/// The elimination tree, and how many blocks each column of the factor has.
void BlockEquations::find_pattern() {
  std::vector<std::size_t> count(size_, 0);
  std::vector<std::size_t> seen_by(size_, kNone);
  for (std::size_t row = 0; row < size_; ++row) {
    seen_by[row] = row;
    for (std::size_t e = first_entry_[row]; e < first_entry_[row + 1]; ++e)
      for (std::size_t i = entries_[e].column; seen_by[i] != row; i = parent_[i]) {
        if (parent_[i] == kNone) parent_[i] = row;
        ++count[i];
        seen_by[i] = row;
      }
  }
  first_below_.assign(size_ + 1, 0);
  std::partial_sum(count.begin(), count.end(), first_below_.begin() + 1);
  below_row_.resize(first_below_.back());
  below_.resize(first_below_.back());
}

void BlockEquations::reset(double diagonal) {
  std::fill(diagonal_.begin(), diagonal_.end(), diagonal * Block::Identity());
  for (Entry& entry : entries_) entry.block.setZero();
  std::fill(x_.begin(), x_.end(), Eigen::Vector3d::Zero());
}

void BlockEquations::add(std::size_t index, const Block& block) {
  const Slot& slot = slots_[index];
  if (slot.entry == kNone)
    diagonal_[slot.row] += block + block.transpose();
  else if (slot.mirrored)
    entries_[slot.entry].block += block.transpose();
  else
    entries_[slot.entry].block += block;
}

bool BlockEquations::solve() {
  std::copy(first_below_.begin(), first_below_.end() - 1, filled_.begin());
  std::fill(marked_by_.begin(), marked_by_.end(), kNone);
  for (std::size_t row = 0; row < size_; ++row)
    if (!factorise_row(row)) return false;
  substitute();
  return true;
}

std::size_t BlockEquations::find_reach(std::size_t row) {
  std::size_t top = size_;
  marked_by_[row] = row;
  for (std::size_t e = first_entry_[row]; e < first_entry_[row + 1]; ++e) {
    std::size_t length = 0;
    for (std::size_t i = entries_[e].column; marked_by_[i] != row; i = parent_[i]) {
      reach_[length++] = i;
      marked_by_[i] = row;
    }
    while (length > 0) reach_[--top] = reach_[--length];
  }
  return top;
}

/// `work_` holds the row of L D while it grows, and is zero again afterwards.
bool BlockEquations::factorise_row(std::size_t row) {
  for (std::size_t e = first_entry_[row]; e < first_entry_[row + 1]; ++e)
    work_[entries_[e].column] = entries_[e].block;
  Block pivot = diagonal_[row];
  for (std::size_t top = find_reach(row); top < size_; ++top) {
    const std::size_t column = reach_[top];
    const Block scaled = work_[column];
    work_[column].setZero();
    const std::size_t end = filled_[column]++;
    for (std::size_t p = first_below_[column]; p < end; ++p)
      work_[below_row_[p]].noalias() -= scaled * below_[p].transpose();
    const Block mirrored = pivots_[column].solve(scaled.transpose());
    pivot.noalias() -= scaled * mirrored;
    below_row_[end] = row;
    below_[end] = mirrored.transpose();
  }
  pivots_[row].compute(pivot);
  return pivots_[row].info() == Eigen::Success;
}

void BlockEquations::substitute() {
  for (std::size_t column = 0; column < size_; ++column)
    for (std::size_t p = first_below_[column]; p < first_below_[column + 1]; ++p)
      x_[below_row_[p]] -= below_[p] * x_[column];
  for (std::size_t i = 0; i < size_; ++i) x_[i] = pivots_[i].solve(x_[i]).eval();
  for (std::size_t column = size_; column-- > 0;)
    for (std::size_t p = first_below_[column]; p < first_below_[column + 1]; ++p)
      x_[column] -= below_[p].transpose() * x_[below_row_[p]];
}

}  // namespace extperfc::mapping
