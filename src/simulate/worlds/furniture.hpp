#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "simulate/worlds/object_model.hpp"

/// Furniture from boxes, cylinders and spheres. All objects stand on z = 0 with their front towards +x.
/// Sizes are [x (depth), y (width), z (height)] in metres.
namespace extperfc::simulate {

[[nodiscard]] ObjectModel table(const Eigen::Vector3d& size_m, const Material& top, const Material& legs);
/// A table with drawers under its left end (+y); one sits at -x.
[[nodiscard]] ObjectModel desk(const Eigen::Vector3d& size_m, const Material& top, const Material& body);
[[nodiscard]] ObjectModel chair(double seat_m, const Material& material);
[[nodiscard]] ObjectModel office_chair(double seat_m, const Material& cushion);
[[nodiscard]] ObjectModel sofa(const Eigen::Vector3d& size_m, const Material& material);
[[nodiscard]] ObjectModel stool(double height_m, const Material& material);

struct ShelfParams {
  Eigen::Vector3d size_m{0.3, 0.9, 1.9};
  int levels{5};          ///< boards that objects can stand on, the lowest one included
  double filled{0.7};     ///< fraction of the boards' length with books on it, [0, 1]
  int empty_level{-1};    ///< from this level on (0 the lowest) nothing is filled in; -1: all are
  std::uint64_t seed{1};  ///< of the books
};
/// Open to the front, with a back wall. A surface per level.
[[nodiscard]] ObjectModel shelf(const ShelfParams& params, const Material& material);

/// Closed, with doors or drawers in front. Movable.
[[nodiscard]] ObjectModel cabinet(const Eigen::Vector3d& size_m, const Material& material, int drawers);
/// Pot with leaves. Movable.
[[nodiscard]] ObjectModel plant(double height_m, std::uint64_t seed);
/// Monitor; its image looks to the front.
[[nodiscard]] ObjectModel screen(double width_m);
[[nodiscard]] ObjectModel keyboard();
[[nodiscard]] ObjectModel desk_lamp(const Material& material);
[[nodiscard]] ObjectModel waste_bin(double height_m, const Material& material);
[[nodiscard]] ObjectModel pillar(double radius_m, double height_m, const Material& material);

/// Coloured areas in a frame, flat on a wall: the origin is the middle of the back, x leaves the wall.
[[nodiscard]] ObjectModel painting(double width_m, double height_m, std::uint64_t seed);
/// A panel that looks like a window with a sky behind it, flat on a wall as painting().
[[nodiscard]] ObjectModel window(double width_m, double height_m);
/// White board with a tray and some writing, flat on a wall as painting().
[[nodiscard]] ObjectModel whiteboard(double width_m, double height_m, std::uint64_t seed);

}  // namespace extperfc::simulate
