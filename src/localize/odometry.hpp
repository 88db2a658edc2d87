#pragma once

#include "extperfc/base/rng.hpp"
#include "extperfc/localize/localizer.hpp"

#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// Standard deviations of the noise on one motion of the base.
struct MotionNoise {
  double first_turn_rad{0};  ///< differential: before driving
  double way_m{0};
  double second_turn_rad{0};  ///< differential: after driving; omni: the whole turn
  double sideways_m{0};       ///< omni
};

/// Probabilistic Robotics, table 5.6, where alpha weighs squares: sigma_turn^2 = alpha1 turn^2 + alpha2
/// way^2, sigma_way^2 = alpha3 way^2 + alpha4 (squares of the turns), omni: sigma_sideways^2 = alpha4 turn^2
/// + alpha5 way^2. Driving backwards is no turn.
[[nodiscard]] MotionNoise motion_noise(const LocalizerParams& params, const Pose2& motion);

/// Moves every particle by `motion` (in the base's frame) with noise of its own.
void move_particles(const LocalizerParams& params, const Pose2& motion, Rng& rng, ParticleSet& particles);

}  // namespace extperfc::localize
