#include "sources/rawlog_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>

namespace extperfc::sources {

namespace {

using mrpt::obs::CObservation3DRangeScan;

constexpr double kMillimetre = 1e-3;

/// Range image in units of scan.rangeUnits, untouched.
cv::Mat raw_range(const CObservation3DRangeScan& scan) {
  const auto rows = static_cast<int>(scan.rangeImage.rows());
  const auto cols = static_cast<int>(scan.rangeImage.cols());
  cv::Mat range(rows, cols, CV_16UC1);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) range.at<std::uint16_t>(y, x) = scan.rangeImage(y, x);
  return range;
}

/// Distances along each pixel's ray become distances along the optical axis.
void range_to_depth(const CameraModel& camera, cv::Mat& range) {
  for (int y = 0; y < range.rows; ++y) {
    for (int x = 0; x < range.cols; ++x) {
      auto& value = range.at<std::uint16_t>(y, x);
      if (value != 0)
        value = static_cast<std::uint16_t>(std::lround(value / camera.back_project(x, y, 1.0).norm()));
    }
  }
}

/// MRPT's sensor frame (x forward, y left, z up) seen from our optical frame (x right, y down, z forward).
Eigen::Matrix3d sensor_R_optical() {
  Eigen::Matrix3d r;
  r << 0, 0, 1,  //
      -1, 0, 0,  //
      0, -1, 0;
  return r;
}

Eigen::Isometry3d color_from_depth(const CObservation3DRangeScan& scan) {
  const auto matrix =
      scan.relativePoseIntensityWRTDepth.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
  Eigen::Isometry3d sensor_T_color = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) sensor_T_color.matrix()(r, c) = matrix(r, c);
  return sensor_T_color.inverse() * Eigen::Isometry3d(sensor_R_optical());
}

bool same_camera(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.distortion == b.distortion;
}

Result<void> check_size(const CameraModel& camera, cv::Size image, const char* which) {
  if (camera.width == image.width && camera.height == image.height) return {};
  return fail(ErrorCode::kCorrupt, std::string(which) + " image is " + std::to_string(image.width) + " x " +
                                       std::to_string(image.height) + " but its camera parameters are for " +
                                       std::to_string(camera.width) + " x " + std::to_string(camera.height));
}

}  // namespace

Result<CameraModel> camera_from_mrpt(const mrpt::img::TCamera& camera) {
  CameraModel model{static_cast<int>(camera.ncols),
                    static_cast<int>(camera.nrows),
                    camera.fx(),
                    camera.fy(),
                    camera.cx(),
                    camera.cy(),
                    {}};
  if (camera.distortion == mrpt::img::DistortionModel::kannala_brandt)
    return fail(ErrorCode::kUnsupported, "a fisheye (Kannala-Brandt) camera; only plumb_bob is supported");
  if (camera.distortion == mrpt::img::DistortionModel::plumb_bob)
    std::copy_n(camera.dist.begin(), model.distortion.size(), model.distortion.begin());
  if (const auto valid = model.validate(); !valid) return tl::unexpected(valid.error());
  return model;
}

Result<cv::Mat> color_of(const CObservation3DRangeScan& scan) {
  if (!scan.hasIntensityImage || scan.intensityImage.isEmpty()) return cv::Mat();
  cv::Mat image;
  scan.intensityImage.asCvMat(image, mrpt::img::DEEP_COPY);
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3)
    return fail(ErrorCode::kUnsupported, "an image of type " + cv::typeToString(image.type()));
  if (image.channels() == 3 && scan.intensityImage.getChannelsOrder() == "RGB")
    cv::cvtColor(image, image, cv::COLOR_RGB2BGR);
  return image;
}

Result<cv::Mat> ScanAligner::depth_of(const CObservation3DRangeScan& scan, cv::Size color_size) {
  if (!scan.hasRangeImage || scan.rangeImage.cols() == 0 || scan.rangeImage.rows() == 0) return cv::Mat();
  cv::Mat range = raw_range(scan);
  if (!scan.range_is_depth) {
    const auto camera = camera_from_mrpt(scan.cameraParams);
    if (!camera) return tl::unexpected(camera.error());
    range_to_depth(*camera, range);
  }
  const bool aligned =
      color_size.empty() || (scan.doDepthAndIntensityCamerasCoincide() &&
                             scan.cameraParams == scan.cameraParamsIntensity && color_size == range.size());
  if (!aligned) return register_depth(scan, range, color_size);
  range.convertTo(range, CV_16U, scan.rangeUnits / kMillimetre);
  return range;
}

Result<cv::Mat> ScanAligner::register_depth(const CObservation3DRangeScan& scan, const cv::Mat& depth,
                                            cv::Size color_size) {
  const auto depth_camera = camera_from_mrpt(scan.cameraParams);
  if (!depth_camera) return tl::unexpected(depth_camera.error());
  const auto color_camera = camera_from_mrpt(scan.cameraParamsIntensity);
  if (!color_camera) return tl::unexpected(color_camera.error());
  if (const auto ok = check_size(*depth_camera, depth.size(), "range"); !ok)
    return tl::unexpected(ok.error());
  if (const auto ok = check_size(*color_camera, color_size, "intensity"); !ok)
    return tl::unexpected(ok.error());
  return registration({*depth_camera, *color_camera, color_from_depth(scan)}).apply(depth, scan.rangeUnits);
}

const DepthRegistration& ScanAligner::registration(const Setup& setup) {
  const bool known = setup_ && same_camera(setup_->depth, setup.depth) &&
                     same_camera(setup_->color, setup.color) &&
                     setup_->color_T_depth.isApprox(setup.color_T_depth, 1e-12);
  if (!known) {
    setup_ = setup;
    registration_.emplace(setup.depth, setup.color, setup.color_T_depth);
  }
  return *registration_;
}

}  // namespace extperfc::sources
