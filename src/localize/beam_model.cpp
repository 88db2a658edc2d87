#include "localize/beam_model.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::localize {

BeamModel::BeamModel(const LocalizerParams& params)
    : z_hit_(params.laser_z_hit),
      z_short_(params.laser_z_short),
      z_max_(params.laser_z_max),
      z_rand_(params.laser_z_rand),
      sigma_m_(params.laser_sigma_hit),
      lambda_short_(params.laser_lambda_short) {
  const double sum = z_hit_ + z_short_ + z_max_ + z_rand_;
  for (double* weight : {&z_hit_, &z_short_, &z_max_, &z_rand_}) *weight /= sum;
}

double BeamModel::likelihood(double range_m, double expected_m, double max_range_m) const {
  const bool expect_miss = expected_m >= max_range_m;
  if (range_m >= max_range_m) return z_max_ + (expect_miss ? z_hit_ : 0);
  double density = z_rand_ / max_range_m;
  if (!expect_miss) {
    const double off = (range_m - expected_m) / sigma_m_;
    density += z_hit_ * std::exp(-off * off / 2) / (sigma_m_ * std::sqrt(kTwoPi));
  }
  if (range_m < expected_m) {
    // The exponential is cut off at the obstacle.
    const double within = -std::expm1(-lambda_short_ * std::min(expected_m, max_range_m));
    density += z_short_ * lambda_short_ * std::exp(-lambda_short_ * range_m) / within;
  }
  return density;
}

void BeamModel::mean_logs(const DistanceField& field, const Beams& beams, const ParticleSet& particles,
                          std::vector<float>& result) const {
  constexpr double kFloor = 1e-6;  // one ray rules no pose out
  result.assign(particles.size(), 0.0F);
  if (beams.range_m.empty()) return;
  const auto longest = static_cast<float>(beams.max_range_m);
  const double hit = z_hit_ / (sigma_m_ * std::sqrt(kTwoPi));
  const double miss = z_hit_ + z_max_;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const float c = std::cos(particles.yaw[p]);
    const float s = std::sin(particles.yaw[p]);
    const float x = particles.x[p] + c * beams.sensor_x_m - s * beams.sensor_y_m;
    const float y = particles.y[p] + s * beams.sensor_x_m + c * beams.sensor_y_m;
    double sum = 0;
    for (std::size_t i = 0; i < beams.range_m.size(); ++i) {
      const float expected = cast_ray(field, x, y, particles.yaw[p] + beams.angle_rad[i], longest);
      const double best = beams.range_m[i] < longest ? hit : miss;
      const double ratio = likelihood(beams.range_m[i], expected, beams.max_range_m) / best;
      sum += std::log(std::clamp(ratio, kFloor, 1.0));
    }
    result[p] = static_cast<float>(sum / static_cast<double>(beams.range_m.size()));
  }
}

float cast_ray(const DistanceField& field, float x_m, float y_m, float angle_rad, float max_range_m) {
  constexpr float kDiagonal = 1.4142136F;  // half at the point's cell, half at the obstacle's
  constexpr float kStep = 0.5F;            // near obstacles [cells]
  const float scale = field.cells_per_m();
  const float step_x = std::cos(angle_rad);
  const float step_y = std::sin(angle_rad);
  const float cells_per_byte = static_cast<float>(field.metres(1)) * scale;
  const float x = x_m * scale + field.margin();
  const float y = y_m * scale + field.margin();
  const float longest = max_range_m * scale;
  float travelled = 0;
  while (travelled < longest) {
    const float column = x + travelled * step_x;
    const float row = y + travelled * step_y;
    if (!(column >= 0 && row >= 0 && column <= field.last_column() && row <= field.last_row()))
      return max_range_m;
    const std::uint8_t byte =
        field.bytes()[static_cast<std::size_t>(row) * static_cast<std::size_t>(field.stride()) +
                      static_cast<std::size_t>(column)];
    const float near = static_cast<float>(byte) * cells_per_byte;
    if (near < 0.5F)
      return std::min(travelled / scale, max_range_m);  // neighbours of an obstacle are 1 cell away
    travelled += std::max(kStep, near - kDiagonal - cells_per_byte);
  }
  return max_range_m;
}

}  // namespace extperfc::localize
