#include "simulate/worlds/object_model.hpp"

#include "simulate/worlds/solid.hpp"

namespace extperfc::simulate {

void add(ObjectModel& model, const Geometry& geometry, const Eigen::Vector3d& xyz_m, const Material& material,
         double yaw_rad) {
  add(model, geometry, upright(xyz_m.x(), xyz_m.y(), xyz_m.z(), yaw_rad), material);
}

void add(ObjectModel& model, const Geometry& geometry, const Pose& object_T_shape, const Material& material) {
  model.shapes.push_back({geometry, object_T_shape, material});
}

BodySpec place(const ObjectModel& model, const std::string& name, const Pose& world_T_object) {
  BodySpec body;
  body.name = name;
  body.label = model.label;
  body.mobility = model.mobility;
  body.shapes = model.shapes;
  body.mass_kg = model.mobility == Mobility::kLoose ? model.mass_kg : 0;
  body.friction = model.friction;
  body.rolling_friction = model.rolling_friction;
  body.world_T_body = world_T_object;
  if (model.mobility != Mobility::kLoose || model.shapes.empty()) return body;
  const Eigen::Vector3d centre = centre_of_mass(model.shapes);
  body.world_T_body.translate(centre);
  for (Shape& shape : body.shapes) shape.body_T_shape.pretranslate(-centre);
  return body;
}

Pose upright(double x_m, double y_m, double z_m, double yaw_rad) {
  return make_pose({x_m, y_m, z_m}, {0, 0, yaw_rad});
}

}  // namespace extperfc::simulate
