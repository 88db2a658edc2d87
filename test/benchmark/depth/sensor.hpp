#pragma once

#include "extperfc/base/rng.hpp"
#include "extperfc/depth/noise_model.hpp"

#include "test/benchmark/depth/scene.hpp"

namespace extperfc::benchmark {

/// What a stereo depth camera makes of a perfect depth image: 16-bit millimetres, aligned to colour.
///
/// 1. Occlusion: points that the right imager cannot see have no depth, a shadow on the left side of objects.
/// 2. Edges: next to a depth jump half of the pixels are lost and some report a depth in between ("flying
/// pixels").
/// 3. Holes: a few round patches without depth.
/// 4. Noise: normal in disparity, `noise.correlation_px` wide, plus a smooth part of `noise.common_fraction`.
/// 5. Rounding to 1 mm.
class StereoSensor {
 public:
  StereoSensor(const CameraModel& camera, const depth::StereoNoiseModel& noise)
      : camera_(camera), noise_(noise) {}

  [[nodiscard]] cv::Mat measure(const Rendering& rendering, Rng& rng) const;

 private:
  void drop_occluded(cv::Mat& depth) const;
  void add_noise(cv::Mat& depth, Rng& rng) const;

  CameraModel camera_;
  depth::StereoNoiseModel noise_;
};

}  // namespace extperfc::benchmark
