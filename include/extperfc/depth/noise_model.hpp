#pragma once

#include <algorithm>
#include <cmath>

namespace extperfc::depth {

/// Depth noise of an active stereo camera: sigma(z) = z^2 * subpixel / (focal * baseline).
/// Defaults are those of the Intel RealSense D435i at 848 x 480 (Intel, "Best-known methods for tuning D400
/// depth cameras"): 3.8 mm at 1 m, 15 mm at 2 m.
///
/// In inverse depth the noise is the same at every distance, because 1/z is proportional to disparity.
struct StereoNoiseModel {
  double focal_px{424.0};
  double baseline_m{0.050};
  double subpixel_px{0.08};
  double correlation_px{7.0};   ///< side of the patch whose errors move together (the matching window), >= 1
  double common_fraction{0.1};  ///< part of the variance that a whole object shares, [0, 1]

  /// Standard deviation [m] of one depth value at distance `z` [m].
  [[nodiscard]] double sigma(double z) const { return z * z * sigma_inverse_depth(); }

  /// Standard deviation [1/m] of the inverse of one depth value.
  [[nodiscard]] double sigma_inverse_depth() const { return subpixel_px / (focal_px * baseline_m); }

  /// What is left of the variance of one pixel in a mean over `pixels` neighbouring pixels, (0, 1].
  ///
  /// Var(mean) = s^2/n^2 * sum_ij rho_ij. With rho = 1 inside patches of correlation_px^2 pixels and 0
  /// between them the sum leaves n / correlation_px^2 independent values; the common part is not averaged at
  /// all.
  [[nodiscard]] double variance_left(double pixels) const {
    const double patches = std::max(1.0, pixels / (correlation_px * correlation_px));
    return common_fraction + (1.0 - common_fraction) / patches;
  }
};

}  // namespace extperfc::depth
