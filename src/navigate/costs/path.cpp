#include "extperfc/navigate/path.hpp"

namespace extperfc::navigate {

double length_m(const Path& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) length += distance_m(path.poses[i - 1], path.poses[i]);
  return length;
}

}  // namespace extperfc::navigate
