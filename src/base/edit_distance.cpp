#include "extperfc/base/edit_distance.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace extperfc {

std::size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> cost(to.size() + 1);  // one row at a time
  std::iota(cost.begin(), cost.end(), std::size_t{0});
  for (std::size_t row = 1; row <= from.size(); ++row) {
    std::size_t upper_left = cost[0];
    cost[0] = row;
    for (std::size_t column = 1; column <= to.size(); ++column) {
      const std::size_t swap = upper_left + (from[row - 1] == to[column - 1] ? 0 : 1);
      upper_left = cost[column];
      cost[column] = std::min({cost[column] + 1, cost[column - 1] + 1, swap});
    }
  }
  return cost.back();
}

}  // namespace extperfc
