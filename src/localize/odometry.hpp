#pragma once

#include "extperfc/base/rng.hpp"
#include "extperfc/localize/localizer.hpp"

#include "localize/particle_set.hpp"

namespace extperfc::localize {

/// Standard deviations of the noise on one motion of the base.
struct MotionNoise {
  double first_rotation_rad{0};  ///< differential: before driving
  double translation_m{0};
  double second_rotation_rad{0};  ///< differential: after driving; omni: the whole rotation
  double sideways_m{0};           ///< omni
};

/// Probabilistic Robotics, table 5.6, with alpha as factors of squares: sigma_rotation^2 = alpha1 rotation^2
/// + alpha2 translation^2, sigma_translation^2 = alpha3 translation^2 + alpha4 (squares of the rotations),
/// omni: sigma_sideways^2 = alpha4 rotation^2 + alpha5 translation^2. Driving backwards is no rotation.
[[nodiscard]] MotionNoise motion_noise(const LocalizerParams& params, const Pose2& motion);

/// Moves every particle by `motion` (in the base's frame) with independent noise.
void move_particles(const LocalizerParams& params, const Pose2& motion, Rng& rng, ParticleSet& particles);

}  // namespace extperfc::localize
