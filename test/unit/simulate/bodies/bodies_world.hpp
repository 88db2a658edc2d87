#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/simulate/bodies.hpp"

namespace extperfc::simulate {

inline constexpr double kStep = 1.0 / 240;

inline Shape shape_of(Geometry geometry, const Pose& pose = Pose::Identity()) {
  Shape shape;
  shape.geometry = std::move(geometry);
  shape.body_T_shape = pose;
  return shape;
}

inline BodySpec body(const std::string& name, Mobility mobility, const Geometry& geometry, const Pose& pose,
                     double mass_kg = 0) {
  BodySpec spec;
  spec.name = name;
  spec.mobility = mobility;
  spec.world_T_body = pose;
  spec.shapes = {shape_of(geometry)};
  spec.mass_kg = mass_kg;
  return spec;
}

inline Box box_of(double x, double y, double z) {
  return Box{{x, y, z}};
}

/// Its top is z = 0.
inline BodySpec make_floor() {
  return body("floor", Mobility::kFixed, box_of(20, 20, 0.2), make_pose({0, 0, -0.1}));
}

inline BodySpec make_cube(const std::string& name, double edge_m, const Eigen::Vector3d& centre) {
  return body(name, Mobility::kLoose, box_of(edge_m, edge_m, edge_m), make_pose(centre), 0.1);
}

/// A robot that is a point far below the floor.
inline const RobotModel& no_robot() {
  static const RobotModel model =
      RobotModel::from_urdf("<robot name='none'><link name='base'/></robot>", "/").value();
  return model;
}

inline const RobotModel& mobile_baxter() {
  static const RobotModel model =
      RobotModel::from_file(std::string(EXTPERFC_SOURCE_DIR) + "/urdf/mobile_baxter.urdf",
                            EXTPERFC_SOURCE_DIR)
          .value();
  return model;
}

inline std::unique_ptr<Bodies> make_bodies(const WorldSpec& world, const RobotModel& robot,
                                           const std::vector<double>& start, bool dynamic = false) {
  BodiesParams params;
  params.dynamic = dynamic;
  auto bodies = Bodies::make(params, robot, world, Pose::Identity(), start);
  if (!bodies) throw std::runtime_error(bodies.error().message);
  return std::move(*bodies);
}

/// A world without a robot.
inline std::unique_ptr<Bodies> make_bodies(const WorldSpec& world) {
  return make_bodies(world, no_robot(), {});
}

inline void step(Bodies& bodies, double duration_s) {
  for (int i = 0; i < std::lround(duration_s / kStep); ++i) bodies.step();
}

}  // namespace extperfc::simulate
