#include "sources/depth_registration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace extperfc::sources {

DepthRegistration::DepthRegistration(const CameraModel& depth, const CameraModel& color,
                                     const Eigen::Isometry3d& color_T_depth)
    : depth_(depth), color_(color), translation_(color_T_depth.translation()) {
  corner_rays_.reserve(static_cast<std::size_t>(depth.width + 1) *
                       static_cast<std::size_t>(depth.height + 1));
  for (int y = 0; y <= depth.height; ++y)
    for (int x = 0; x <= depth.width; ++x)
      corner_rays_.push_back(color_T_depth.linear() * depth.back_project(x - 0.5, y - 0.5, 1.0));
}

Eigen::Vector3d DepthRegistration::in_color(int corner_x, int corner_y, double z) const {
  const auto index = static_cast<std::size_t>(corner_y) * static_cast<std::size_t>(depth_.width + 1) +
                     static_cast<std::size_t>(corner_x);
  return z * corner_rays_[index] + translation_;
}

void DepthRegistration::splat(int x, int y, double z, cv::Mat& out) const {
  constexpr double kNearest = 1e-3;  // [m] in front of the colour camera; nearer cannot be projected
  const Eigen::Vector3d first = in_color(x, y, z);
  const Eigen::Vector3d last = in_color(x + 1, y + 1, z);
  if (first.z() < kNearest || last.z() < kNearest) return;
  const double mm = 500.0 * (first.z() + last.z());
  if (mm > std::numeric_limits<std::uint16_t>::max()) return;
  const Eigen::Vector2d a = color_.project(first);
  const Eigen::Vector2d b = color_.project(last);
  const Eigen::Vector2d low = a.cwiseMin(b);
  const Eigen::Vector2d high = a.cwiseMax(b);
  if (!(high.x() > -0.5 && high.y() > -0.5 && low.x() < color_.width && low.y() < color_.height)) return;

  const auto value = static_cast<std::uint16_t>(std::lround(mm));
  const int x0 = static_cast<int>(std::ceil(std::max(low.x(), 0.0)));
  const int y0 = static_cast<int>(std::ceil(std::max(low.y(), 0.0)));
  const int x1 = static_cast<int>(std::ceil(std::min(high.x(), static_cast<double>(color_.width))));
  const int y1 = static_cast<int>(std::ceil(std::min(high.y(), static_cast<double>(color_.height))));
  for (int v = y0; v < y1; ++v) {
    for (int u = x0; u < x1; ++u) {
      auto& pixel = out.at<std::uint16_t>(v, u);
      if (pixel == 0 || value < pixel) pixel = value;
    }
  }
}

cv::Mat DepthRegistration::apply(const cv::Mat& depth, double unit_m) const {
  cv::Mat out = cv::Mat::zeros(color_.height, color_.width, CV_16UC1);
  for (int y = 0; y < depth_.height; ++y)
    for (int x = 0; x < depth_.width; ++x)
      if (const auto raw = depth.at<std::uint16_t>(y, x); raw != 0) splat(x, y, raw * unit_m, out);
  return out;
}

}  // namespace extperfc::sources
