#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "simulate/worlds/object_model.hpp"

namespace extperfc::simulate {

/// A hole in a wall.
struct Opening {
  std::size_t segment{0};  ///< of the polyline, from 0
  double at_m{0};          ///< from the segment's start to the opening's middle
  double width_m{0.95};
  double sill_m{0};  ///< lower edge above the floor
  double top_m{2.05};
};

/// Walls along a polyline on the floor; the line is the wall's middle.
struct WallParams {
  std::vector<Eigen::Vector2d> path_m;
  bool closed{false};
  double height_m{2.6};
  double thickness_m{0.12};
  bool skirting{true};
  std::vector<Opening> openings;  ///< must lie within their segments, without overlap
};

[[nodiscard]] std::size_t segment_count(const WallParams& params);
[[nodiscard]] double segment_length_m(const WallParams& params, std::size_t segment);
/// Origin at the middle of an opening on the floor, x along the segment.
[[nodiscard]] Pose opening_pose(const WallParams& params, const Opening& opening);

/// In world coordinates: its frame is the world's.
[[nodiscard]] ObjectModel walls(const WallParams& params, const Material& material);

struct DoorParams {
  double width_m{0.95};
  double height_m{2.05};
  double thickness_m{0.04};
  bool hinge_right{false};  ///< seen along +y of the door's frame, its hinge is at +x instead of -x
};
/// Leaf of a door, movable. Its frame stands at the hinge on the floor; the leaf lies along +x when shut, so
/// a rotation about z opens it.
[[nodiscard]] ObjectModel door(const DoorParams& params, const Material& material);
/// Pose of the leaf in a frame in the middle of the opening, x along the wall.
[[nodiscard]] Pose door_pose(const DoorParams& params, double open_rad);

}  // namespace extperfc::simulate
