#pragma once

#include "extperfc/base/rng.hpp"

#include "simulate/worlds/object_model.hpp"

/// Objects of any look for training images. They are seen, not simulated: their masses mean nothing.
namespace extperfc::simulate {

/// Any colour, matte or glossy, plain, printed, patterned, wooden or translucent-looking.
[[nodiscard]] Material varied_material(Rng& rng);

/// A cone, cube or sphere from 2 to 30 cm: also traffic cones, dice, cartons, balls.
[[nodiscard]] ObjectModel varied_target(Rng& rng);

/// Looks like one of them at a glance and is none. Labelled can, cup, egg, dome, pyramid, prism, slab,
/// bucket, board, vase, disc, cylinder, bottle or roll.
[[nodiscard]] ObjectModel look_alike(Rng& rng);

/// A hand with its forearm: fingertips towards +x, palm down, wrist at the origin.
[[nodiscard]] ObjectModel hand(Rng& rng);

/// A two-finger gripper: fingertips towards +x, wrist at the origin. `opening_m` between the fingers.
[[nodiscard]] ObjectModel gripper_fingers(Rng& rng, double opening_m);

/// A cable that wanders over a table within about 0.4 m.
[[nodiscard]] ObjectModel cable(Rng& rng);

}  // namespace extperfc::simulate
