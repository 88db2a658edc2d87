#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "extperfc/world/camera_model.hpp"

namespace extperfc::sources {

/// Moves depth images from the depth camera into the colour camera of one device.
///
/// Every depth pixel becomes a small rectangle facing the camera, whose corners are projected into the colour
/// image and filled, so that a denser colour image gets no holes; the nearest surface wins. Rays are
/// computed once.
class DepthRegistration {
 public:
  /// Both cameras must validate(). `color_T_depth` moves points between the optical frames [m].
  DepthRegistration(const CameraModel& depth, const CameraModel& color,
                    const Eigen::Isometry3d& color_T_depth);

  /// Aligned depth [mm] of the colour camera's size; 0 = no measurement. `depth` is CV_16UC1 of the depth
  /// camera's size in units of `unit_m` [m] along the optical axis.
  [[nodiscard]] cv::Mat apply(const cv::Mat& depth, double unit_m) const;

 private:
  void splat(int x, int y, double z, cv::Mat& out) const;
  [[nodiscard]] Eigen::Vector3d in_color(int corner_x, int corner_y, double z) const;

  CameraModel depth_;
  CameraModel color_;
  Eigen::Vector3d translation_;
  std::vector<Eigen::Vector3d> corner_rays_;  // (width + 1) x (height + 1), rotated into the colour frame
};

}  // namespace extperfc::sources
