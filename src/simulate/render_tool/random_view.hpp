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

/// Optical frame at `eye` that looks at `target`, upright but for `roll_rad` about the view.
[[nodiscard]] Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double roll_rad);

/// Where to look: the places of the labelled bodies [m].
[[nodiscard]] std::vector<Eigen::Vector3d> targets_of(const WorldSpec& world,
                                                      const std::vector<std::string>& classes);

/// Where cameras stand and how they are held.
struct ViewRange {
  double min_distance_m{0.35};  ///< from a target
  double max_distance_m{2.2};
  double min_elevation_deg{6};  ///< of the camera above the target
  double max_elevation_deg{62};
  double roll_rad{0.05};  ///< standard deviation
};
/// As a hand-held camera may stand: near and far, low and from above, askew.
inline constexpr ViewRange kAnyView{0.22, 3.2, -4, 86, 0.2};

/// Optical frame of a camera as a robot's head or hand has it: within the range, 0.1 to 2.4 m above the
/// floor, looking slightly past a target, inside the floor plan.
[[nodiscard]] Pose random_view(Rng& rng, const WorldSpec& world, const std::vector<Eigen::Vector3d>& targets,
                               const ViewRange& range = {});

}  // namespace extperfc::simulate
