#include <algorithm>

#include "extperfc/simulate/sensor_rig.hpp"

namespace extperfc::simulate {

std::vector<VisibleBox> visible_boxes(const CameraImages& images, const std::vector<Instance>& instances,
                                      int min_pixels) {
  std::vector<VisibleBox> by_instance(instances.size());
  for (int y = 0; y < images.height; ++y) {
    const auto* row = images.instance.data() + static_cast<std::size_t>(y) * images.width;
    for (int x = 0; x < images.width; ++x) {
      if (row[x] == 0 || row[x] >= by_instance.size()) continue;
      auto& box = by_instance[row[x]];
      if (box.pixels++ == 0) box = {row[x], x, y, x, y, 1};
      box.x_min = std::min(box.x_min, x);
      box.x_max = std::max(box.x_max, x);
      box.y_max = y;
    }
  }
  std::vector<VisibleBox> boxes;
  for (const auto& box : by_instance)
    if (box.pixels >= std::max(1, min_pixels) &&
        !instances[static_cast<std::size_t>(box.instance)].label.empty())
      boxes.push_back(box);
  return boxes;
}

}  // namespace extperfc::simulate
