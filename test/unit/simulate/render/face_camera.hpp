#pragma once

#include <array>
#include <cmath>

#include "simulate/render/head_shape.hpp"
#include "test/unit/simulate/render/small_world.hpp"

namespace extperfc::simulate {

/// A person before a wall, and a camera at the height of the head that looks at it.
class FaceCamera {
 public:
  explicit FaceCamera(int seed) : face_(face_features(seed)) {
    world_.add("wall", Box{{0.1, 12, 6}}, at(3, 0, 1.5), {{0.85F, 0.84F, 0.8F}, Texture::kPlaster, 1.5F, 0});
    PersonSpec person;
    person.name = "person";
    person.path_m = {{0, 0}};
    person.face = seed;
    world_.spec.people.push_back(person);
    world_.spec.light.position_m = {-1.5, 0.8, 2.6};
    rig_ = world_.rig();
  }

  /// The camera stands `distance_m` before the face, which is rotated away from it by `yaw`. Horizontal field
  /// of view: 69 degrees.
  const CameraImages& look(double distance_m, double yaw) {
    world_T_person_ = to_pose(Pose2{0, 0, M_PI + yaw});
    Snapshot snapshot = world_.snapshot();
    snapshot.world_T_person = {{0, 0, M_PI + yaw}};
    rig_->pose(snapshot);
    world_T_optical_ = forward_camera({-0.09 - distance_m, 0, 1.6});
    params_.model = {640, 480, kFocal_px, kFocal_px, 319.5, 239.5, {}};
    rig_->camera(params_, world_T_optical_, images_);
    return images_;
  }

  /// Landmarks in the camera's frame [m].
  [[nodiscard]] std::array<Eigen::Vector3d, 5> landmarks() const {
    std::array<Eigen::Vector3d, 5> points;
    const auto in_person = face_landmarks(face_);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i] = world_T_optical_.inverse() * (world_T_person_ * in_person[i].cast<double>());
    return points;
  }
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& point) const {
    return params_.model.project(point);
  }

 private:
  static constexpr double kFocal_px = 465.6;

  FaceFeatures face_;
  SmallWorld world_;
  std::unique_ptr<SensorRig> rig_;
  CameraParams params_;
  CameraImages images_;
  Pose world_T_person_{Pose::Identity()};
  Pose world_T_optical_{Pose::Identity()};
};

}  // namespace extperfc::simulate
