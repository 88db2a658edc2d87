#include "detect/ssd_priors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace extperfc::detect {

namespace {

/// Width and height of every box of a cell [input pixels].
std::vector<std::array<float, 2>> box_sizes(const PriorLevel& level) {
  std::vector<std::array<float, 2>> sizes{{level.min_size, level.min_size}};
  if (level.max_size > 0) {
    const float side = std::sqrt(level.min_size * level.max_size);
    sizes.push_back({side, side});
  }
  for (const float ratio : level.aspect_ratios) {
    const float root = std::sqrt(ratio);
    sizes.push_back({level.min_size * root, level.min_size / root});
    sizes.push_back({level.min_size / root, level.min_size * root});
  }
  return sizes;
}

Prior clipped(Prior prior) {
  for (float* value : {&prior.cx, &prior.cy, &prior.w, &prior.h}) *value = std::clamp(*value, 0.0F, 1.0F);
  return prior;
}

}  // namespace

std::vector<Prior> make_priors(const std::vector<PriorLevel>& levels, int input_width, int input_height,
                               bool clip) {
  const auto width = static_cast<float>(input_width);
  const auto height = static_cast<float>(input_height);
  std::vector<Prior> priors;
  for (const PriorLevel& level : levels) {
    const auto stride = static_cast<float>(level.stride);
    const auto sizes = box_sizes(level);
    for (int row = 0; row < level.rows; ++row)
      for (int column = 0; column < level.columns; ++column)
        for (const auto& [w, h] : sizes) {
          const Prior prior{(static_cast<float>(column) + 0.5F) * stride / width,
                            (static_cast<float>(row) + 0.5F) * stride / height, w / width, h / height};
          priors.push_back(clip ? clipped(prior) : prior);
        }
  }
  return priors;
}

}  // namespace extperfc::detect
