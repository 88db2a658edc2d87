#pragma once

#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::simulate {

/// How a body would look if nothing stood before it and the image had no border. Numbers of pixels.
struct WholeView {
  double pixels{0};         ///< in the image and outside
  double pixels_inside{0};  ///< in the image
};

/// Casts a ray through the body's shapes for every pixel near it, or for every n-th of large bodies. A camera
/// without distortion. Of a body that reaches around the camera, one image's size on every side counts.
[[nodiscard]] WholeView whole_view(const BodySpec& body, const CameraModel& camera,
                                   const Pose& world_T_optical);

}  // namespace extperfc::simulate
