#pragma once

#include <cmath>

namespace extperfc::depth {

/// Depth noise of an active stereo camera: sigma(z) = z^2 * subpixel / (focal * baseline).
/// Defaults are those of the Intel RealSense D435i at 848 x 480 (Intel, "Best-known methods for tuning D400 depth
/// cameras"): 3.8 mm at 1 m, 15 mm at 2 m.
struct StereoNoiseModel {
  double focal_px{424.0};
  double baseline_m{0.050};
  double subpixel_px{0.08};

  /// Standard deviation [m] of one depth value at distance `z` [m].
  [[nodiscard]] double sigma(double z) const { return z * z * subpixel_px / (focal_px * baseline_m); }
};

}  // namespace extperfc::depth
