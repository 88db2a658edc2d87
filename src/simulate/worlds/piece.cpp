#include "simulate/worlds/piece.hpp"

#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate::worlds {

void add(Piece& piece, const Geometry& geometry, const Eigen::Vector3d& xyz_m, const Material& material,
         double yaw_rad) {
  add(piece, geometry, upright(xyz_m.x(), xyz_m.y(), xyz_m.z(), yaw_rad), material);
}

void add(Piece& piece, const Geometry& geometry, const Pose& piece_T_shape, const Material& material) {
  piece.shapes.push_back({geometry, piece_T_shape, material});
}

BodySpec place(const Piece& piece, const std::string& name, const Pose& world_T_piece) {
  BodySpec body;
  body.name = name;
  body.label = piece.label;
  body.mobility = piece.mobility;
  body.shapes = piece.shapes;
  body.mass_kg = piece.mobility == Mobility::kLoose ? piece.mass_kg : 0;
  body.friction = piece.friction;
  body.rolling_friction = piece.rolling_friction;
  body.world_T_body = world_T_piece;
  if (piece.mobility != Mobility::kLoose || piece.shapes.empty()) return body;
  const Eigen::Vector3d centre = centre_of_mass(piece.shapes);
  body.world_T_body.translate(centre);
  for (Shape& shape : body.shapes) shape.body_T_shape.pretranslate(-centre);
  return body;
}

Pose upright(double x_m, double y_m, double z_m, double yaw_rad) {
  return make_pose({x_m, y_m, z_m}, {0, 0, yaw_rad});
}

}  // namespace extperfc::simulate::worlds
