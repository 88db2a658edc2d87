#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render/hash_noise.hpp"

namespace extperfc::simulate {

/// Errors of an active stereo camera whose depth is aligned to colour. Works on disparity, where the noise is
/// the same at every distance: d = focal * baseline / z.
class DepthNoise {
 public:
  /// Fills images.depth_mm from images.true_depth_m. O(pixels).
  void apply(const CameraParams& params, NoiseKey key, CameraImages& images);

 private:
  /// Matching noise of a row of pixels: the same in patches, standard deviation 1.
  void draw_noise(NoiseKey key, int patch, int y, int width);
  /// Pixels that the right eye does not see, because something nearer lies to the right of them.
  /// `shift_per_disparity`: pixels of the image per pixel of the infrared pair.
  void find_shadow(const float* disparities, int width, float shift_per_disparity);

  std::array<std::vector<float>, 3> disparities_;
  std::vector<float> lattice_;  ///< noise at the corners of the patches, blended to the row
  std::vector<float> noise_;
  std::vector<float> nearest_;    ///< largest shift that lands in a column of the right eye
  std::vector<float> in_shadow_;  ///< 1: yes
};

}  // namespace extperfc::simulate
