#pragma once

#include <vector>

#include "extperfc/detect/model_spec.hpp"

namespace extperfc::detect {

/// Prior boxes of one feature map.
struct PriorLevel {
  int columns{0};
  int rows{0};
  int stride{0};      ///< input pixels per cell
  float min_size{0};  ///< side of the first square [input pixels]
  float max_size{0};  ///< second square has side sqrt(min_size * max_size); 0 = no second square
  std::vector<float> aspect_ratios;  ///< each gives a wide and a tall box with the first square's area
};

/// Liu et al. 2016, section 2.2. Level after level, rows, columns; per cell: square, larger square, then per
/// ratio the wide and the tall box. `clip` limits every value to [0, 1].
[[nodiscard]] std::vector<Prior> make_priors(const std::vector<PriorLevel>& levels, int input_width,
                                             int input_height, bool clip);

}  // namespace extperfc::detect
