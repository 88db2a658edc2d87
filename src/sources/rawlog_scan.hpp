#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <opencv2/core/mat.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"

#include "sources/depth_registration.hpp"

namespace extperfc::sources {

/// Our camera model of MRPT's. kUnsupported for other lenses than plumb_bob, kInvalidArgument when not
/// calibrated.
[[nodiscard]] Result<CameraModel> camera_from_mrpt(const mrpt::img::TCamera& camera);

/// Image of an observation: BGR or grey, empty when it has none. Throws std::exception when a separate file
/// is missing.
[[nodiscard]] Result<cv::Mat> color_of(const mrpt::obs::CObservation3DRangeScan& scan);

/// Turns range images into depth [mm] that is aligned to colour. Keeps the rays between frames of one
/// camera.
class ScanAligner {
 public:
  /// Depth for a colour image of `color_size` (empty: stay in the depth camera). Empty when there is no
  /// range image.
  [[nodiscard]] Result<cv::Mat> depth_of(const mrpt::obs::CObservation3DRangeScan& scan, cv::Size color_size);

 private:
  struct Setup {
    CameraModel depth;
    CameraModel color;
    Eigen::Isometry3d color_T_depth;
  };
  [[nodiscard]] Result<cv::Mat> register_depth(const mrpt::obs::CObservation3DRangeScan& scan,
                                               const cv::Mat& depth, cv::Size color_size);
  [[nodiscard]] const DepthRegistration& registration(const Setup& setup);

  std::optional<Setup> setup_;
  std::optional<DepthRegistration> registration_;
};

}  // namespace extperfc::sources
