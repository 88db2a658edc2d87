#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "simulate/worlds/piece.hpp"

/// Furniture from boxes, cylinders and spheres. All pieces stand on z = 0 with their front towards +x.
/// Sizes are [x (depth), y (width), z (height)] in metres.
namespace extperfc::simulate::worlds {

[[nodiscard]] Piece table(const Eigen::Vector3d& size_m, const Material& top, const Material& legs);
/// A table with drawers under its left end (+y); one sits at -x.
[[nodiscard]] Piece desk(const Eigen::Vector3d& size_m, const Material& top, const Material& body);
[[nodiscard]] Piece chair(double seat_m, const Material& material);
[[nodiscard]] Piece office_chair(double seat_m, const Material& cushion);
[[nodiscard]] Piece sofa(const Eigen::Vector3d& size_m, const Material& material);
[[nodiscard]] Piece stool(double height_m, const Material& material);

struct ShelfParams {
  Eigen::Vector3d size_m{0.3, 0.9, 1.9};
  int levels{5};          ///< boards that things can stand on, the lowest one included
  double filled{0.7};     ///< share of the boards' length with books on it, [0, 1]
  int empty_level{-1};    ///< from this level on (0 the lowest) nothing is filled in; -1: all are
  std::uint64_t seed{1};  ///< of the books
};
/// Open to the front, with a back wall. A surface per level.
[[nodiscard]] Piece shelf(const ShelfParams& params, const Material& material);

/// Closed, with doors or drawers in front. Movable.
[[nodiscard]] Piece cabinet(const Eigen::Vector3d& size_m, const Material& material, int drawers);
/// Pot with leaves. Movable.
[[nodiscard]] Piece plant(double height_m, std::uint64_t seed);
/// Monitor; its image looks to the front.
[[nodiscard]] Piece screen(double width_m);
[[nodiscard]] Piece keyboard();
[[nodiscard]] Piece desk_lamp(const Material& material);
[[nodiscard]] Piece waste_bin(double height_m, const Material& material);
[[nodiscard]] Piece pillar(double radius_m, double height_m, const Material& material);

/// Coloured areas in a frame, flat on a wall: the origin is the middle of the back, x leaves the wall.
[[nodiscard]] Piece painting(double width_m, double height_m, std::uint64_t seed);
/// A panel that looks like a window with a sky behind it, flat on a wall as painting().
[[nodiscard]] Piece window(double width_m, double height_m);
/// White board with a tray and some writing, flat on a wall as painting().
[[nodiscard]] Piece whiteboard(double width_m, double height_m, std::uint64_t seed);

}  // namespace extperfc::simulate::worlds
