#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "extperfc/simulate/sensor_rig.hpp"

namespace extperfc::simulate {

/// Worlds of a few shapes, made in code. Instances are 2, 3, ... in the order of the bodies.
class SmallWorld {
 public:
  SmallWorld& add(const std::string& name, const Geometry& geometry, const Pose& world_T_body,
                  const Material& material = {}, Mobility mobility = Mobility::kMovable) {
    BodySpec body;
    body.name = name;
    body.label = name;
    body.mobility = mobility;
    body.world_T_body = world_T_body;
    body.mass_kg = 1;
    body.shapes.push_back({geometry, Pose::Identity(), material});
    spec.bodies.push_back(std::move(body));
    return *this;
  }

  [[nodiscard]] std::unique_ptr<SensorRig> rig(std::uint64_t seed = 1,
                                               const RobotModel& robot = RobotModel{}) const {
    auto made = SensorRig::make(robot, spec, seed);
    if (!made) throw std::runtime_error(made.error().message);
    return std::move(*made);
  }

  [[nodiscard]] Snapshot snapshot(double time_s = 0) const {
    Snapshot snapshot;
    snapshot.time_s = time_s;
    for (const auto& body : spec.bodies) snapshot.world_T_body.push_back(body.world_T_body);
    for (const auto& person : spec.people)
      snapshot.world_T_person.push_back({person.path_m.front().x(), person.path_m.front().y(), 0});
    return snapshot;
  }

  WorldSpec spec;
};

inline Pose at(double x, double y, double z) {
  return make_pose({x, y, z});
}

/// A camera at `position` that looks along the world's x axis, upright.
inline Pose forward_camera(const Eigen::Vector3d& position) {
  Pose world_T_optical = Pose::Identity();
  world_T_optical.linear().col(0) = -Eigen::Vector3d::UnitY();
  world_T_optical.linear().col(1) = -Eigen::Vector3d::UnitZ();
  world_T_optical.linear().col(2) = Eigen::Vector3d::UnitX();
  world_T_optical.translation() = position;
  return world_T_optical;
}

/// No noise, no holes, no limits that matter.
inline CameraParams exact_camera(int width = 160, int height = 120, double focal_px = 150) {
  CameraParams params;
  params.model = {width, height, focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1), {}};
  params.image_noise = 0;
  params.depth.subpixel_px = 0;
  params.depth.hole_probability = 0;
  params.depth.edge_holes = 0;
  params.depth.max_depth_m = 60;
  return params;
}

inline LidarParams exact_lidar() {
  LidarParams params;
  params.range_noise_m = 0;
  params.quantum_m = 1e-6;
  params.drop_probability = 0;
  return params;
}

}  // namespace extperfc::simulate
