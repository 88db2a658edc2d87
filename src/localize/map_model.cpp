#include "localize/map_model.hpp"

#include <algorithm>
#include <cmath>

#include "localize/beam_model.hpp"

namespace extperfc::localize {

namespace {

constexpr double kWidening = 2;

/// Calls `visit` with the field's byte at every end point.
template <typename Visit>
void visit_ends(const DistanceField& field, const Beams& beams, const Pose2& pose, Visit visit) {
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  for (std::size_t i = 0; i < beams.ends(); ++i)
    visit(field.at(static_cast<float>(pose.x + c * beams.x_m[i] - s * beams.y_m[i]),
                   static_cast<float>(pose.y + s * beams.x_m[i] + c * beams.y_m[i])));
}

}  // namespace

MapModel::MapModel(std::shared_ptr<const OccupancyGrid> the_map, const LocalizerParams& params)
    : map(std::move(the_map)),
      field(*map, params.laser_likelihood_max_dist),
      free_space(map),
      exact(params.laser_z_hit, params.laser_z_rand, params.laser_sigma_hit, field),
      wide(params.laser_z_hit, params.laser_z_rand, kWidening * params.laser_sigma_hit, field),
      rand_per_hit(params.laser_z_rand / params.laser_z_hit) {}

double MapModel::mean_log(const Beams& beams, const Pose2& pose) const {
  if (beams.ends() == 0) return 0;
  double sum = 0;
  visit_ends(field, beams, pose, [&](std::uint8_t byte) { sum += exact.log_of(byte); });
  return sum / static_cast<double>(beams.ends());
}

double MapModel::agreement(const Beams& beams, const Pose2& pose, std::size_t max_rays) const {
  constexpr double kThrough_m = 0.3;  // beyond an obstacle
  constexpr double kShort = -1;       // log likelihood of an object that the map does not contain
  constexpr double kGone = -1.5;      // the same of an object that only the map contains
  if (beams.ends() == 0) return 0;
  const Pose2 sensor = compose(pose, {beams.sensor_x_m, beams.sensor_y_m, 0});
  const double impossible = std::log(rand_per_hit / (1 + rand_per_hit));
  const std::size_t every = (beams.ends() + max_rays - 1) / max_rays;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < beams.ends(); i += every, ++count) {
    const auto angle = static_cast<float>(sensor.yaw + beams.angle_rad[i]);
    const auto x = static_cast<float>(sensor.x + beams.range_m[i] * std::cos(angle));
    const auto y = static_cast<float>(sensor.y + beams.range_m[i] * std::sin(angle));
    const double end = exact.log_of(field.at(x, y));
    const auto clear = static_cast<float>(beams.range_m[i] - kThrough_m);
    const bool through = clear > 0 && cast_ray(field, static_cast<float>(sensor.x),
                                               static_cast<float>(sensor.y), angle, clear) < clear;
    sum += !through ? std::max(kShort, end) : end > kShort ? kGone : impossible;
  }
  return sum / static_cast<double>(count);
}

double MapModel::fit(const Beams& beams, const Pose2& pose) const {
  constexpr double kNear_m = 0.15;
  if (beams.ends() == 0) return 0;
  const double near = std::max(kNear_m, 1.5 * map->resolution_m);
  std::size_t hits = 0;
  visit_ends(field, beams, pose,
             [&](std::uint8_t byte) { hits += byte < 255 && field.metres(byte) <= near; });
  return static_cast<double>(hits) / static_cast<double>(beams.ends());
}

}  // namespace extperfc::localize
