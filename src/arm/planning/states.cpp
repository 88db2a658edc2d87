#include "arm/planning/states.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace extperfc::arm {

int nearest(const std::vector<JointVector>& states, const JointVector& to) {
  int nearest = -1;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double distance = (states[i] - to).squaredNorm();
    if (distance >= smallest) continue;
    smallest = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

std::vector<int> by_distance(const JointVector& from, const std::vector<JointVector>& states) {
  std::vector<int> order(states.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return (states[a] - from).squaredNorm() < (states[b] - from).squaredNorm();
  });
  return order;
}

}  // namespace extperfc::arm
