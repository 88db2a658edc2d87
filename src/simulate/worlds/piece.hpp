#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate::worlds {

/// A flat place on a piece where things can stand.
struct Surface {
  double z_m{0};                                      ///< above the piece's underside
  Eigen::Vector2d half_m{0, 0};                       ///< half its size along the piece's x and y
  Eigen::Vector2d centre_m{Eigen::Vector2d::Zero()};  ///< of the rectangle, in the piece's frame
  double clear_m{1e3};                                ///< free height above it
};

/// Something to be put into a world. Its frame: middle of the underside, z up, x to the front.
struct Piece {
  std::vector<Shape> shapes;
  std::vector<Surface> surfaces;  ///< lowest first
  Mobility mobility{Mobility::kFixed};
  std::string label;
  double mass_kg{0};  ///< of a loose piece
  double friction{0.8};
  double rolling_friction{0.001};
};

/// Adds a shape whose centre is at `xyz` (turned about z by `yaw_rad`).
void add(Piece& piece, const Geometry& geometry, const Eigen::Vector3d& xyz_m, const Material& material,
         double yaw_rad = 0);
/// Adds a shape anywhere.
void add(Piece& piece, const Geometry& geometry, const Pose& piece_T_shape, const Material& material);

/// The body of a piece that stands at `world_T_piece`. A loose body's frame moves to its centre of mass.
[[nodiscard]] BodySpec place(const Piece& piece, const std::string& name, const Pose& world_T_piece);

/// Pose on the floor plan at height z, turned about z.
[[nodiscard]] Pose upright(double x_m, double y_m, double z_m, double yaw_rad);

}  // namespace extperfc::simulate::worlds
