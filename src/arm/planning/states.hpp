#pragma once

#include <vector>

#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::arm {

/// Index of the state nearest to `to` (Euclidean); -1 of none. O(states).
[[nodiscard]] int nearest(const std::vector<JointVector>& states, const JointVector& to);

/// Indices of the states, the one nearest to `from` first.
[[nodiscard]] std::vector<int> by_distance(const JointVector& from, const std::vector<JointVector>& states);

}  // namespace extperfc::arm
