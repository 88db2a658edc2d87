#include "localize/refine.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace extperfc::localize {

namespace {

/// The normal equations of one step, without the prior.
struct Normal {
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d gradient{Eigen::Vector3d::Zero()};
};

Normal linearise(const DistanceField& field, const Beams& beams, const Pose2& pose, double sigma_m,
                 double rand_per_hit) {
  Normal normal;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const double per_variance = 1 / (sigma_m * sigma_m);
  for (std::size_t i = 0; i < beams.ends(); ++i) {
    const double dx = c * beams.x_m[i] - s * beams.y_m[i];
    const double dy = s * beams.x_m[i] + c * beams.y_m[i];
    const auto near =
        smooth_distance(field, static_cast<float>(pose.x + dx), static_cast<float>(pose.y + dy));
    const double hit = std::exp(-0.5 * near.metres * near.metres * per_variance);
    const double weight = hit / (hit + rand_per_hit) * per_variance;
    const Eigen::Vector3d slope(near.slope_x, near.slope_y, near.slope_y * dx - near.slope_x * dy);
    normal.information += weight * slope * slope.transpose();
    normal.gradient += weight * near.metres * slope;
  }
  return normal;
}

}  // namespace

bool is_near(const Pose2& a, const Pose2& b, double within_m, double within_rad) {
  return distance_m(a, b) < within_m && std::abs(wrap_angle(a.yaw - b.yaw)) < within_rad;
}

SmoothDistance smooth_distance(const DistanceField& field, float x_m, float y_m) {
  const float scale = field.cells_per_m();
  const float column = std::clamp(x_m * scale + field.margin() - 0.5F, 0.0F, field.last_column() - 1.5F);
  const float row = std::clamp(y_m * scale + field.margin() - 0.5F, 0.0F, field.last_row() - 1.5F);
  const auto i = static_cast<std::size_t>(column);
  const auto j = static_cast<std::size_t>(row);
  const float u = column - static_cast<float>(i);
  const float v = row - static_cast<float>(j);
  const auto stride = static_cast<std::size_t>(field.stride());
  const std::uint8_t* low = field.bytes() + j * stride + i;
  const std::uint8_t* high = low + stride;
  const auto step = static_cast<float>(field.metres(1));
  const float a = static_cast<float>(low[0]) * step;
  const float b = static_cast<float>(low[1]) * step;
  const float c = static_cast<float>(high[0]) * step;
  const float d = static_cast<float>(high[1]) * step;
  return {(a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v,
          ((b - a) * (1 - v) + (d - c) * v) * scale, ((c - a) * (1 - u) + (d - b) * u) * scale};
}

Refined refine(const DistanceField& field, const Beams& beams, const Pose2& start,
               const Eigen::Matrix3d& prior_information, double sigma_m, double rand_per_hit) {
  constexpr int kSteps = 8;
  constexpr double kWidest = 4;  // of sigma, at the first step
  constexpr double kLongestStep_m = 0.1;
  Pose2 pose = start;
  for (int step = 0; step < kSteps; ++step) {
    const double wide = std::max(1.0, kWidest * std::pow(0.5, 0.5 * step));
    Normal normal = linearise(field, beams, pose, wide * sigma_m, rand_per_hit);
    const Eigen::Vector3d off(pose.x - start.x, pose.y - start.y, wrap_angle(pose.yaw - start.yaw));
    normal.gradient += prior_information * off;
    Eigen::Vector3d change = -(normal.information + prior_information).ldlt().solve(normal.gradient);
    if (!change.allFinite()) break;
    change *= std::min(1.0, kLongestStep_m / std::max(change.norm(), 1e-9));
    pose = {pose.x + change.x(), pose.y + change.y(), wrap_angle(pose.yaw + change.z())};
  }
  return {pose, linearise(field, beams, pose, sigma_m, rand_per_hit).information};
}

}  // namespace extperfc::localize
