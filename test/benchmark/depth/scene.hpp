#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::benchmark {

enum class Shape { kCone, kCube, kSphere };

/// One object on a floor in front of a wall, optical frame [m].
struct Scene {
  Shape shape{Shape::kCone};
  double size_m{0.1};              ///< height of a cone, side of a cube, diameter of a sphere
  double cone_radius_m{0.04};      ///< of the cone's base
  double yaw_rad{0};               ///< of the object around `up`
  Eigen::Vector3d base{0, 0, 1};   ///< where the object stands
  Eigen::Vector3d up{0, -1, 0};    ///< unit normal of the floor
  Eigen::Vector3d wall{0, 0, -1};  ///< unit normal of the wall, towards the camera
  double wall_distance_m{1};       ///< from `base` to the wall
};

/// What a perfect camera sees of a scene.
struct Rendering {
  cv::Mat depth;      ///< CV_32FC1 [m]; 0 = nothing there or outside the rendered part
  cv::Mat object;     ///< CV_8UC1, 255 where the object is seen
  cv::Rect part;      ///< pixels that were rendered: the object's surroundings
  Box2 box;           ///< tight around the object's visible pixels; no area when it is not seen
  double truth_m{0};  ///< depth of the object's visible pixel nearest to the centre of `box`
};

/// Casts one ray through each pixel centre of the object's surroundings.
[[nodiscard]] Rendering render(const Scene& scene, const CameraModel& camera);

}  // namespace extperfc::benchmark
