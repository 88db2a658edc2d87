#include "localize/odometry.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::localize {

namespace {

/// The motion as turn, way, turn.
struct Legs {
  double first_turn{0};
  double way{0};
  double second_turn{0};
};

Legs legs_of(const Pose2& motion) {
  constexpr double kNoDirection = 0.01;  // [m] below, the direction of the way is noise of the encoders
  Legs legs;
  legs.way = std::hypot(motion.x, motion.y);
  legs.first_turn = legs.way < kNoDirection ? 0 : std::atan2(motion.y, motion.x);
  legs.second_turn = wrap_angle(motion.yaw - legs.first_turn);
  return legs;
}

double square(double value) {
  return value * value;
}

/// Forwards and backwards are the same to a wheel.
double turn_size(double turn) {
  return std::min(std::abs(wrap_angle(turn)), std::abs(wrap_angle(turn - M_PI)));
}

void move_differential(const Pose2& motion, const MotionNoise& noise, Rng& rng, ParticleSet& particles) {
  const Legs legs = legs_of(motion);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double first = legs.first_turn + rng.normal(0, 1) * noise.first_turn_rad;
    const double way = legs.way + rng.normal(0, 1) * noise.way_m;
    const double second = legs.second_turn + rng.normal(0, 1) * noise.second_turn_rad;
    const double heading = particles.yaw[i] + first;
    particles.set(i, static_cast<float>(particles.x[i] + way * std::cos(heading)),
                  static_cast<float>(particles.y[i] + way * std::sin(heading)),
                  static_cast<float>(wrap_angle(heading + second)));
  }
}

void move_omni(const Pose2& motion, const MotionNoise& noise, Rng& rng, ParticleSet& particles) {
  const double length = std::hypot(motion.x, motion.y);
  const double direction = length > 0 ? std::atan2(motion.y, motion.x) : 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double way = length + rng.normal(0, 1) * noise.way_m;
    const double turn = motion.yaw + rng.normal(0, 1) * noise.second_turn_rad;
    const double sideways = rng.normal(0, 1) * noise.sideways_m;
    const double c = std::cos(particles.yaw[i] + direction);
    const double s = std::sin(particles.yaw[i] + direction);
    particles.set(i, static_cast<float>(particles.x[i] + way * c - sideways * s),
                  static_cast<float>(particles.y[i] + way * s + sideways * c),
                  static_cast<float>(wrap_angle(particles.yaw[i] + turn)));
  }
}

}  // namespace

MotionNoise motion_noise(const LocalizerParams& p, const Pose2& motion) {
  MotionNoise noise;
  if (p.odometry_model == OdometryModel::kOmni) {
    const double way2 = square(motion.x) + square(motion.y);
    const double turn2 = square(motion.yaw);
    noise.way_m = std::sqrt(p.odom_alpha3 * way2 + p.odom_alpha4 * turn2);
    noise.second_turn_rad = std::sqrt(p.odom_alpha1 * turn2 + p.odom_alpha2 * way2);
    noise.sideways_m = std::sqrt(p.odom_alpha4 * turn2 + p.odom_alpha5 * way2);
    return noise;
  }
  const Legs legs = legs_of(motion);
  const double first2 = square(turn_size(legs.first_turn));
  const double second2 = square(turn_size(legs.second_turn));
  const double way2 = square(legs.way);
  noise.first_turn_rad = std::sqrt(p.odom_alpha1 * first2 + p.odom_alpha2 * way2);
  noise.way_m = std::sqrt(p.odom_alpha3 * way2 + p.odom_alpha4 * (first2 + second2));
  noise.second_turn_rad = std::sqrt(p.odom_alpha1 * second2 + p.odom_alpha2 * way2);
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
