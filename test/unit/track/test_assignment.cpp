// Assignments against all permutations.
#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/track/assignment.hpp"

namespace extperfc::track {
namespace {

double sum_of(const Eigen::MatrixXd& cost, const std::vector<int>& column_of) {
  double sum = 0.0;
  for (std::size_t row = 0; row < column_of.size(); ++row)
    if (column_of[row] >= 0) sum += cost(static_cast<Eigen::Index>(row), column_of[row]);
  return sum;
}

/// Smallest sum over all complete assignments of the shorter side.
double smallest_sum(const Eigen::MatrixXd& cost) {
  if (cost.rows() > cost.cols()) return smallest_sum(cost.transpose());
  std::vector<int> columns(static_cast<std::size_t>(cost.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  double best = std::numeric_limits<double>::infinity();
  do {
    double sum = 0.0;
    for (Eigen::Index row = 0; row < cost.rows(); ++row)
      sum += cost(row, columns[static_cast<std::size_t>(row)]);
    best = std::min(best, sum);
  } while (std::next_permutation(columns.begin(), columns.end()));
  return best;
}

TEST(Assignment, IsTheBestOfAllPermutations) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    Eigen::MatrixXd cost(rng.integer(1, 6), rng.integer(1, 6));
    for (auto& value : cost.reshaped())
      value = rng.chance(0.3) ? 20.0 : rng.uniform(-5.0, 20.0);  // with ties
    const auto column_of = assign(cost);
    ASSERT_EQ(column_of.size(), static_cast<std::size_t>(cost.rows()));
    std::set<int> given;
    for (const int column : column_of) {
      if (column < 0) continue;
      EXPECT_TRUE(column < cost.cols() && given.insert(column).second);
    }
    EXPECT_EQ(given.size(), static_cast<std::size_t>(std::min(cost.rows(), cost.cols())));
    EXPECT_NEAR(sum_of(cost, column_of), smallest_sum(cost), 1e-9) << cost;
  }
}

TEST(Assignment, GreedyWouldBeWorse) {
  Eigen::MatrixXd cost(2, 2);
  cost << 1, 2, 2, 100;
  EXPECT_EQ(assign(cost), (std::vector<int>{1, 0}));
}

TEST(Assignment, NothingToAssign) {
  EXPECT_TRUE(assign(Eigen::MatrixXd(0, 0)).empty());
  EXPECT_TRUE(assign(Eigen::MatrixXd(0, 3)).empty());
  EXPECT_EQ(assign(Eigen::MatrixXd(3, 0)), (std::vector<int>{-1, -1, -1}));
}

}  // namespace
}  // namespace extperfc::track
