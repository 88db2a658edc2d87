#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/noise_model.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::depth {

/// What a standing object is taken for.
enum class FitShape {
  kCube,    ///< three equal edges, on one of its faces
  kSphere,  ///< on the support
  kCone,    ///< on its base, the tip up
};

struct ObjectFitParams {
  double min_depth_m{0.105};    ///< nearer values are no measurement, > 0 [m]
  double max_depth_m{10.0};     ///< farther values are no measurement, > min_depth_m [m]
  double surround{0.5};         ///< the support is looked for so far around the box, in box sides, [0.1, 3]
  double tilt_sigma_rad{0.02};  ///< standard deviation of the support's normal against `up`, [1e-4, 0.3]
  double min_size_m{0.01};      ///< smallest edge, diameter or height of an object, > 0 [m]
  double max_size_m{0.40};      ///< largest one, > min_size_m [m]
  int min_object_px{30};        ///< fewer pixels above the support are not an object, >= 10
  int min_support_px{60};       ///< fewer pixels of the support around the box are none, >= 10
  double max_rms{3.0};          ///< largest spread about the shape, in standard deviations of the noise, > 1
  double min_fitting{0.6};      ///< fraction of the object's pixels that must lie on the shape, (0, 1]
  std::uint64_t seed{1};        ///< of the search for the support
  StereoNoiseModel noise;
};

/// An object that stands on a level support.
struct ObjectFit {
  /// In the optical frame. The origin is the middle of the object, half its height above the support; z is
  /// the support's normal; x is the normal of a cube's face, else it points away from the camera.
  Pose camera_T_object{Pose::Identity()};
  Eigen::Vector3d size_m{0, 0, 0};   ///< along the object's axes: edges; diameters; diameters and height
  Eigen::Matrix3d covariance;        ///< of the origin, optical frame [m^2]
  double size_sigma_m{0};            ///< of size_m.x() [m]
  double rms_m{0};                   ///< spread of the object's pixels about the shape [m]
  int object_px{0};                  ///< pixels that the shape rests on
  int support_px{0};                 ///< pixels that the support rests on
  Eigen::Vector3d support{0, 0, 0};  ///< point of the support under the object, optical frame [m]
};

/// Pose and size of the object in `box`, from the depth image and the shape that the detector names.
///
/// 1. Support: the plane with a normal near `up` that most pixels around the box lie on (RANSAC, Fischler and
///    Bolles 1981), then least squares with `up` as prior knowledge of the normal.
/// 2. Object: the pixels of the box that rise above the support.
/// 3. Shape: least distances of these pixels from the surface of a sphere (x, y, radius), a cone (x, y,
///    radius, height) or a cube (x, y, edge, yaw; several starts) that stands on the support; Gauss-Newton
///    with Cauchy weights.
///
/// The part of the object that is hidden comes from the shape alone, so a lying cone or a long box is taken
/// for something else, or refused. `depth` is kDepth16Mm or kDepth32M, aligned to the image of `box`; `up`
/// is a unit vector against gravity in the optical frame. Errors: kInvalidArgument for a parameter out of its
/// range, another image format, an empty box or a zero `up`; kNotFound, with a reason in one line, when
/// there is no depth, no support, nothing on it, or the object is not of this shape or size. Bounded
/// time: at most about 4,000 pixels are read; some 5 ms, a cube 10 ms. Thread-safe.
[[nodiscard]] Result<ObjectFit> fit_object(const ImageView& depth, const CameraModel& camera, const Box2& box,
                                           FitShape shape, const Eigen::Vector3d& up,
                                           const ObjectFitParams& params = {});

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const ObjectFitParams& params);

}  // namespace extperfc::depth
