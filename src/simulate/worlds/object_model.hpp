#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/simulate/world_spec.hpp"

namespace extperfc::simulate {

inline constexpr double kRightAngle = 1.57079632679489662;  ///< [rad]

/// A flat place on an object where objects can stand.
struct Surface {
  double z_m{0};                                      ///< above the object's underside
  Eigen::Vector2d half_m{0, 0};                       ///< half its size along the object's x and y
  Eigen::Vector2d centre_m{Eigen::Vector2d::Zero()};  ///< of the rectangle, in the object's frame
  double clear_m{1e3};                                ///< free height above it
};

/// Something to be put into a world. Its frame: middle of the underside, z up, x to the front.
struct ObjectModel {
  std::vector<Shape> shapes;
  std::vector<Surface> surfaces;  ///< lowest first
  Mobility mobility{Mobility::kFixed};
  std::string label;
  double mass_kg{0};  ///< of a loose object
  double friction{0.8};
  double rolling_friction{0.001};
};

/// Adds a shape whose centre is at `xyz` (turned about z by `yaw_rad`).
void add(ObjectModel& model, const Geometry& geometry, const Eigen::Vector3d& xyz_m, const Material& material,
         double yaw_rad = 0);
/// Adds a shape anywhere.
void add(ObjectModel& model, const Geometry& geometry, const Pose& object_T_shape, const Material& material);

/// The body of an object that stands at `world_T_object`. A loose body's frame moves to its centre of mass.
[[nodiscard]] BodySpec place(const ObjectModel& model, const std::string& name, const Pose& world_T_object);

/// Pose on the floor plan at height z, turned about z.
[[nodiscard]] Pose upright(double x_m, double y_m, double z_m, double yaw_rad);

}  // namespace extperfc::simulate
