#pragma once

#include <vector>

#include <Eigen/Core>

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::simulate {

/// Colour camera of a D435i at this size, with a few per cent of variation.
[[nodiscard]] CameraModel random_camera(Rng& rng, int width, int height);

/// Where to look: the places of the labelled bodies [m].
[[nodiscard]] std::vector<Eigen::Vector3d> targets_of(const WorldSpec& world,
                                                      const std::vector<std::string>& classes);

/// Optical frame of a camera as a robot's head or hand has it: 0.35 to 2.2 m from a target, 0.1 to 2.4 m
/// above the floor, looking slightly past the target, inside the floor plan, hardly tilted.
[[nodiscard]] Pose random_view(Rng& rng, const WorldSpec& world, const std::vector<Eigen::Vector3d>& targets);

}  // namespace extperfc::simulate
