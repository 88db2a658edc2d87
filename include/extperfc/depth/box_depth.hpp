#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/noise_model.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::depth {

enum class Estimator {
  kMean,         ///< ExtPerFC: D = 1/(w h) * sum d(i, j) over the valid pixels of a window at the box centre
  kMedian,       ///< median of the same window
  kTrimmedMean,  ///< mean of the same window without its lowest and highest fifth
  kNearestMode,  ///< nearest dense mode of the depths in the central part of the box
};

[[nodiscard]] Result<Estimator> estimator_from_name(
    const std::string& name);  ///< mean, median, trimmed_mean, nearest_mode
[[nodiscard]] const char* to_string(Estimator estimator);

struct BoxDepthParams {
  Estimator estimator{Estimator::kNearestMode};
  int window_px{20};             ///< side of the square window of mean, median and trimmed mean, [1, 1000]
  double central_fraction{0.4};  ///< part of the box's width and height that nearest_mode looks at, (0, 1]
  double min_depth_m{0.105};     ///< nearer values are no measurement (the D435i's own limit)
  double max_depth_m{10.0};      ///< farther values are no measurement
  int min_valid_px{5};           ///< fewer valid pixels give no estimate, >= 1
  StereoNoiseModel noise;
};

/// What the depth image says about one box.
struct BoxDepth {
  double depth_m{0};         ///< along the optical axis, to the visible surface
  double sigma_m{0};         ///< standard deviation of depth_m, from the noise model and the spread
  int valid_px{0};           ///< pixels that the estimate rests on
  double valid_fraction{0};  ///< valid pixels / pixels of the region looked at, [0, 1]
};

/// Depth of the object in `box`. Empty when no valid estimate exists: the box lies outside the image, is
/// not finite or has no area, or fewer than min_valid_px pixels are valid.
///
/// `depth` is kDepth16Mm or kDepth32M, of the same size as the colour image that `box` refers to. Zeros,
/// NaN, infinities and values outside [min, max] are not valid. The box is clipped to the image, so
/// "centre" is that of its visible part; nearest_mode looks at the whole box where the central part has too
/// few valid pixels. Regions of more than 1024 pixels are read on a regular grid: bounded time, no heap.
/// Precondition: validate(params) passed.
[[nodiscard]] std::optional<BoxDepth> estimate_depth(const ImageView& depth, const Box2& box,
                                                     const BoxDepthParams& params);

/// An object in the optical frame.
struct Object3 {
  Eigen::Vector3d surface;  ///< point of the visible surface behind the box centre [m]
  Eigen::Vector3d
      center;  ///< estimate of the object's centre: surface pushed back along the ray by half the extent [m]
  Eigen::Vector3d size;  ///< extent along x, y (from the box at that depth) and z (the smaller of both) [m]
  Eigen::Matrix3d surface_covariance;  ///< from the depth and the box's own error [m^2]
  /// The same for `center`, and what a box leaves open: how far behind its surface an object of unknown shape
  /// has its centre, and how far beside the middle of what is seen of it [m^2].
  Eigen::Matrix3d center_covariance;
};

/// Puts box and depth together. Precondition: camera.validate() passed and depth.depth_m > 0.
[[nodiscard]] Object3 locate(const CameraModel& camera, const Box2& box, const BoxDepth& depth);

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const BoxDepthParams& params);

}  // namespace extperfc::depth
