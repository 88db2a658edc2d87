#include "localize/odometry.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::localize {

namespace {

/// The motion as rotation, translation, rotation.
struct Legs {
  double first_rotation{0};
  double translation{0};
  double second_rotation{0};
};

Legs legs_of(const Pose2& motion) {
  constexpr double kNoDirection =
      0.01;  // [m] below, the direction of the translation is noise of the encoders
  Legs legs;
  legs.translation = std::hypot(motion.x, motion.y);
  legs.first_rotation = legs.translation < kNoDirection ? 0 : std::atan2(motion.y, motion.x);
  legs.second_rotation = wrap_angle(motion.yaw - legs.first_rotation);
  return legs;
}

/// Driving backwards is no rotation by pi.
double rotation_size(double rotation) {
  return std::min(std::abs(wrap_angle(rotation)), std::abs(wrap_angle(rotation - kPi)));
}

void move_differential(const Pose2& motion, const MotionNoise& noise, Rng& rng, ParticleSet& particles) {
  const Legs legs = legs_of(motion);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double first = legs.first_rotation + rng.normal(0, 1) * noise.first_rotation_rad;
    const double translation = legs.translation + rng.normal(0, 1) * noise.translation_m;
    const double second = legs.second_rotation + rng.normal(0, 1) * noise.second_rotation_rad;
    const double heading = particles.yaw[i] + first;
    particles.set(i, static_cast<float>(particles.x[i] + translation * std::cos(heading)),
                  static_cast<float>(particles.y[i] + translation * std::sin(heading)),
                  static_cast<float>(wrap_angle(heading + second)));
  }
}

void move_omni(const Pose2& motion, const MotionNoise& noise, Rng& rng, ParticleSet& particles) {
  const double length = std::hypot(motion.x, motion.y);
  const double direction = length > 0 ? std::atan2(motion.y, motion.x) : 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double translation = length + rng.normal(0, 1) * noise.translation_m;
    const double rotation = motion.yaw + rng.normal(0, 1) * noise.second_rotation_rad;
    const double sideways = rng.normal(0, 1) * noise.sideways_m;
    const double c = std::cos(particles.yaw[i] + direction);
    const double s = std::sin(particles.yaw[i] + direction);
    particles.set(i, static_cast<float>(particles.x[i] + translation * c - sideways * s),
                  static_cast<float>(particles.y[i] + translation * s + sideways * c),
                  static_cast<float>(wrap_angle(particles.yaw[i] + rotation)));
  }
}

}  // namespace

MotionNoise motion_noise(const LocalizerParams& p, const Pose2& motion) {
  MotionNoise noise;
  if (p.odometry_model == OdometryModel::kOmni) {
    const double translation2 = square(motion.x) + square(motion.y);
    const double rotation2 = square(motion.yaw);
    noise.translation_m = std::sqrt(p.odom_alpha3 * translation2 + p.odom_alpha4 * rotation2);
    noise.second_rotation_rad = std::sqrt(p.odom_alpha1 * rotation2 + p.odom_alpha2 * translation2);
    noise.sideways_m = std::sqrt(p.odom_alpha4 * rotation2 + p.odom_alpha5 * translation2);
    return noise;
  }
  const Legs legs = legs_of(motion);
  const double first2 = square(rotation_size(legs.first_rotation));
  const double second2 = square(rotation_size(legs.second_rotation));
  const double translation2 = square(legs.translation);
  noise.first_rotation_rad = std::sqrt(p.odom_alpha1 * first2 + p.odom_alpha2 * translation2);
  noise.translation_m = std::sqrt(p.odom_alpha3 * translation2 + p.odom_alpha4 * (first2 + second2));
  noise.second_rotation_rad = std::sqrt(p.odom_alpha1 * second2 + p.odom_alpha2 * translation2);
  return noise;
}

void move_particles(const LocalizerParams& params, const Pose2& motion, Rng& rng, ParticleSet& particles) {
  const MotionNoise noise = motion_noise(params, motion);
  if (params.odometry_model == OdometryModel::kOmni)
    move_omni(motion, noise, rng, particles);
  else
    move_differential(motion, noise, rng, particles);
}

}  // namespace extperfc::localize
