#include "extperfc/navigate/path.hpp"

#include <cmath>

namespace extperfc::navigate {

double length_m(const Path& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i)
    length += std::hypot(path.poses[i].x - path.poses[i - 1].x, path.poses[i].y - path.poses[i - 1].y);
  return length;
}

}  // namespace extperfc::navigate
