#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "mapping/block_equations.hpp"

namespace extperfc::mapping {
namespace {

using Block = BlockEquations::Block;
using BlockIndex = BlockEquations::BlockIndex;

Block random_block(Rng& rng) {
  Block block;
  for (int i = 0; i < 9; ++i) block(i / 3, i % 3) = rng.uniform(-1, 1);
  return block;
}

Eigen::Vector3d random_vector(Rng& rng) {
  return {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
}

Eigen::Index row_of(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

/// The same equations twice: by blocks, and as a full matrix.
class Twice {
 public:
  Twice(std::size_t nodes, std::vector<BlockIndex> indices)
      : nodes_(nodes), indices_(std::move(indices)), blocks_(nodes, indices_) {}

  /// Positive definite: every row's diagonal outweighs the rest.
  void fill(Rng& rng) {
    const double diagonal = 3.0 * static_cast<double>(indices_.size() + 1);
    blocks_.reset(diagonal);
    full_ = diagonal * Eigen::MatrixXd::Identity(row_of(nodes_), row_of(nodes_));
    right_ = Eigen::VectorXd::Zero(row_of(nodes_));
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      const Block block = random_block(rng);
      const auto [row, column] = indices_[i];
      blocks_.add(i, block);
      full_.block<3, 3>(row_of(row), row_of(column)) += block;
      full_.block<3, 3>(row_of(column), row_of(row)) += block.transpose();
    }
    for (std::size_t i = 0; i < nodes_; ++i) {
      const Block root = random_block(rng);
      const Eigen::Vector3d b = random_vector(rng);
      blocks_.add_diagonal(i, root * root.transpose());
      blocks_.add_right_side(i, b);
      full_.block<3, 3>(row_of(i), row_of(i)) += root * root.transpose();
      right_.segment<3>(row_of(i)) += b;
    }
  }

  void expect_same_solution() {
    ASSERT_TRUE(blocks_.solve());
    const Eigen::VectorXd expected = full_.llt().solve(right_);
    for (std::size_t i = 0; i < nodes_; ++i)
      EXPECT_LT((blocks_.solution(i) - expected.segment<3>(row_of(i))).norm(), 1e-12) << i;
  }

 private:
  std::size_t nodes_;
  std::vector<BlockIndex> indices_;
  BlockEquations blocks_;
  Eigen::MatrixXd full_;
  Eigen::VectorXd right_;
};

std::vector<BlockIndex> random_indices(std::size_t nodes, std::size_t number, Rng& rng) {
  std::vector<BlockIndex> indices;
  const int last = static_cast<int>(nodes) - 1;
  for (std::size_t i = 0; i < number; ++i)
    indices.emplace_back(static_cast<std::size_t>(rng.integer(0, last)),
                         static_cast<std::size_t>(rng.integer(0, last)));
  return indices;
}

// Any pattern: indices on both sides of the diagonal, on it, and more than once.
TEST(BlockEquations, SolveWhatAFullMatrixSolves) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const auto nodes = static_cast<std::size_t>(rng.integer(1, 25));
    const auto number = static_cast<std::size_t>(rng.integer(0, 60));
    Twice twice(nodes, random_indices(nodes, number, rng));
    for (int round = 0; round < 3; ++round) {  // filled anew, with the order that was found once
      twice.fill(rng);
      twice.expect_same_solution();
    }
  }
}

TEST(BlockEquations, SolveAChainWithLoops) {
  Rng rng(7);
  constexpr std::size_t kNodes = 120;
  std::vector<BlockIndex> indices;
  for (std::size_t i = 1; i < kNodes; ++i) indices.emplace_back(i, i - 1);
  for (std::size_t i = 60; i < kNodes; i += 7) indices.emplace_back(i, i - 60);
  Twice twice(kNodes, indices);
  twice.fill(rng);
  twice.expect_same_solution();
}

TEST(BlockEquations, SayWhatIsNotPositiveDefinite) {
  BlockEquations equations(3, {{1, 0}, {2, 1}});
  equations.reset(1);
  equations.add(0, 2 * Block::Identity());  // [1 2; 2 1] has the eigenvalue -1
  EXPECT_FALSE(equations.solve());
  equations.reset(0);
  EXPECT_FALSE(equations.solve());
  equations.reset(1);  // and go on thereafter
  equations.add(0, 0.5 * Block::Identity());
  equations.add_right_side(0, {1, 2, 3});
  ASSERT_TRUE(equations.solve());
  const Eigen::Vector3d x0(1, 2, 3);  // x1 = -x0 / 2 and x0 + x1 / 2 = b0; nothing ties node 2
  EXPECT_LT((equations.solution(0) - x0 / 0.75).norm(), 1e-12);
  EXPECT_LT((equations.solution(1) + 0.5 * x0 / 0.75).norm(), 1e-12);
  EXPECT_LT(equations.solution(2).norm(), 1e-12);
}

TEST(BlockEquations, NoNodes) {
  BlockEquations equations(0, {});
  equations.reset(1);
  EXPECT_TRUE(equations.solve());
}

}  // namespace
}  // namespace extperfc::mapping
