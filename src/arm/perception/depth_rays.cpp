#include "arm/perception/depth_rays.hpp"

#include <cmath>
#include <cstring>
#include <limits>

namespace extperfc::arm {
namespace {

bool same(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.distortion == b.distortion;
}

}  // namespace

void DepthRays::set(const CameraModel& camera) {
  if (same(camera, camera_)) return;
  camera_ = camera;
  columns_ = (camera.width + step_ - 1) / step_;
  rows_ = (camera.height + step_ - 1) / step_;
  rays_.clear();
  rays_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const Eigen::Vector2d ray = camera.back_project(column * step_, row * step_, 1.0).head<2>();
      rays_.emplace_back(ray.cast<float>());
      low = low.cwiseMin(ray);
      high = high.cwiseMax(ray);
    }
  constexpr double kBeside = 0.1;
  low_ = low - kBeside * (high - low);
  high_ = high + kBeside * (high - low);
}

float depth_at(const ImageView& image, int u, int v) {
  const std::uint8_t* const row = image.row(v);
  if (image.format == PixelFormat::kDepth16Mm) {
    std::uint16_t millimetres = 0;
    std::memcpy(&millimetres, row + 2 * static_cast<std::size_t>(u), sizeof millimetres);
    return 1e-3F * static_cast<float>(millimetres);
  }
  float metres = 0;
  std::memcpy(&metres, row + 4 * static_cast<std::size_t>(u), sizeof metres);
  return std::isfinite(metres) && metres > 0 ? metres : 0;
}

}  // namespace extperfc::arm
