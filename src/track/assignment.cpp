#include "extperfc/track/assignment.hpp"

#include <cstddef>
#include <limits>

namespace extperfc::track {

namespace {

constexpr int kFree = -1;

/// Rows are given columns one after the other; rows <= columns.
class Solver {
 public:
  explicit Solver(const Eigen::MatrixXd& cost)
      : cost_(cost),
        row_dual_(Eigen::VectorXd::Zero(cost.rows())),
        column_dual_(Eigen::VectorXd::Zero(cost.cols())),
        row_of_(static_cast<std::size_t>(cost.cols()), kFree) {}

  std::vector<int> solve() {
    for (int row = 0; row < cost_.rows(); ++row) augment(row);
    std::vector<int> column_of(static_cast<std::size_t>(cost_.rows()), kFree);
    for (std::size_t column = 0; column < row_of_.size(); ++column)
      if (row_of_[column] != kFree)
        column_of[static_cast<std::size_t>(row_of_[column])] = static_cast<int>(column);
    return column_of;
  }

 private:
  /// The shortest alternating path from a row to a free column, by Dijkstra's algorithm on reduced costs.
  void augment(int start) {
    const auto columns = cost_.cols();
    Eigen::VectorXd distance = Eigen::VectorXd::Constant(columns, std::numeric_limits<double>::infinity());
    std::vector<int> previous(static_cast<std::size_t>(columns), kFree);  // column before, on the path
    std::vector<bool> done(static_cast<std::size_t>(columns), false);
    int row = start;
    int column = kFree;
    double length = 0.0;  // of the path to `row`
    do {
      const int from = column;
      column = nearest(row, from, length, distance, previous, done);
      length = distance[column];
      done[static_cast<std::size_t>(column)] = true;
      row = row_of_[static_cast<std::size_t>(column)];
    } while (row != kFree);
    update_duals(start, length, distance, done);
    flip(start, column, previous);
  }

  /// Relaxes the edges of `row`, and returns the open column with the smallest distance.
  int nearest(int row, int from, double length, Eigen::VectorXd& distance, std::vector<int>& previous,
              const std::vector<bool>& done) const {
    int best = kFree;
    for (int column = 0; column < cost_.cols(); ++column) {
      if (done[static_cast<std::size_t>(column)]) continue;
      const double through = length + cost_(row, column) - row_dual_[row] - column_dual_[column];
      if (through < distance[column]) {
        distance[column] = through;
        previous[static_cast<std::size_t>(column)] = from;
      }
      if (best == kFree || distance[column] < distance[best]) best = column;
    }
    return best;
  }

  void update_duals(int start, double length, const Eigen::VectorXd& distance,
                    const std::vector<bool>& done) {
    row_dual_[start] += length;
    for (int column = 0; column < cost_.cols(); ++column) {
      if (!done[static_cast<std::size_t>(column)]) continue;
      const double change = length - distance[column];
      column_dual_[column] -= change;
      if (const int row = row_of_[static_cast<std::size_t>(column)]; row != kFree) row_dual_[row] += change;
    }
  }

  void flip(int start, int column, const std::vector<int>& previous) {
    while (column != kFree) {
      const int before = previous[static_cast<std::size_t>(column)];
      row_of_[static_cast<std::size_t>(column)] =
          before == kFree ? start : row_of_[static_cast<std::size_t>(before)];
      column = before;
    }
  }

  const Eigen::MatrixXd& cost_;
  Eigen::VectorXd row_dual_;
  Eigen::VectorXd column_dual_;
  std::vector<int> row_of_;  // by column
};

}  // namespace

std::vector<int> assign(const Eigen::MatrixXd& cost) {
  if (cost.rows() <= cost.cols()) return Solver(cost).solve();
  const Eigen::MatrixXd transposed = cost.transpose();
  const auto row_of = Solver(transposed).solve();
  std::vector<int> column_of(static_cast<std::size_t>(cost.rows()), kFree);
  for (std::size_t column = 0; column < row_of.size(); ++column)
    column_of[static_cast<std::size_t>(row_of[column])] = static_cast<int>(column);
  return column_of;
}

}  // namespace extperfc::track
