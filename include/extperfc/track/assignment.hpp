#pragma once

#include <vector>

#include <Eigen/Core>

namespace extperfc::track {

/// Which column each row gets so that the sum of `cost` over all pairs is smallest and as many rows as
/// possible have one: -1 for a row that gets none. Every column is given once at most.
///
/// The linear assignment problem by shortest augmenting paths with dual variables (Jonker and Volgenant,
/// "A shortest augmenting path algorithm for dense and sparse linear assignment problems", Computing 38,
/// 1987, without its initialization): O(n^2 m) for n <= m. Precondition: every cost is finite.
[[nodiscard]] std::vector<int> assign(const Eigen::MatrixXd& cost);

}  // namespace extperfc::track
