#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/srdf.hpp"
#include "extperfc/base/rng.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm::test {

/// Throws the error.
inline void must(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error().message);
}

inline const RobotModel& baxter() {
  static const RobotModel robot =
      RobotModel::from_file(EXTPERFC_SOURCE_DIR "/urdf/mobile_baxter.urdf", EXTPERFC_SOURCE_DIR).value();
  return robot;
}

inline const Srdf& baxter_srdf() {
  static const Srdf srdf = read_srdf(EXTPERFC_SOURCE_DIR "/config/robots/baxter/mobile_baxter.srdf").value();
  return srdf;
}

inline CollisionModelParams group_params(const std::string& group) {
  CollisionModelParams params;
  params.joints = joints_of_group(baxter_srdf(), baxter(), group).value();
  params.allowed = allowed_pairs(baxter_srdf());
  return params;
}

inline CollisionModel group_model(const std::string& group) {
  return CollisionModel::make(baxter(), group_params(group)).value();
}

inline JointVector random_state(const JointLimits& limits, Rng& rng) {
  JointVector state(limits.lower.size());
  for (Eigen::Index i = 0; i < state.size(); ++i) state[i] = rng.uniform(limits.lower[i], limits.upper[i]);
  return state;
}

inline Pose random_pose(Rng& rng, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Eigen::Vector3d position, rotation;
  for (int i = 0; i < 3; ++i) position[i] = rng.uniform(low[i], high[i]);
  for (int i = 0; i < 3; ++i) rotation[i] = rng.uniform(-3, 3);
  return make_pose(position, rotation);
}

inline Geometry random_geometry(int kind, Rng& rng) {
  const auto size = [&] { return rng.uniform(0.03, 0.3); };
  switch (kind % 5) {
    case 0:
      return Box{{size(), size(), size()}};
    case 1:
      return Cylinder{size() / 2, size()};
    case 2:
      return Sphere{size() / 2};
    case 3:
      return Cone{size() / 2, size()};
    default:
      return TriangleMesh{EXTPERFC_SOURCE_DIR "/urdf/meshes/upper_elbow_housing.stl", {1, 1, 1}};
  }
}

/// Objects of every kind in front of and beside the robot, every second one upright.
inline CollisionWorld random_world(int count, Rng& rng) {
  CollisionWorld world;
  for (int i = 0; i < count; ++i) {
    WorldObject object{
        "object_" + std::to_string(i), {}, random_pose(rng, {-0.3, -1.2, 0.2}, {1.3, 1.2, 1.6})};
    if (i % 2 == 0) object.root_T_object.linear().setIdentity();
    Shape shape;
    shape.geometry = random_geometry(i, rng);
    object.shapes = {shape};
    must(world.add(object));
  }
  return world;
}

}  // namespace extperfc::arm::test
