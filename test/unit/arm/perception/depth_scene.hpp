#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/arm/srdf.hpp"
#include "extperfc/world/camera_model.hpp"
#include "extperfc/world/image_view.hpp"
#include "extperfc/world/robot_model.hpp"

#include "arm/collision/bodies.hpp"
#include "arm/collision/convex_part.hpp"

namespace extperfc::arm::test {

/// Convex solids and what a camera without noise sees of them: rays walk by the distance bound of the nearest
/// solid until they are within 0.1 mm ("sphere tracing").
class DepthScene {
 public:
  void add(std::shared_ptr<const ConvexPart> part, const Pose& root_T_part) {
    solids_.push_back({std::move(part), root_T_part.inverse()});
  }
  void add(const Geometry& geometry, const Pose& root_T_shape) {
    Shape shape;
    shape.geometry = geometry;
    add(make_convex_part(shape).value(), root_T_shape);
  }
  /// Every link of the model.
  void add(const CollisionModel& model, const JointVector& positions) {
    std::vector<Pose> poses;
    body_poses(model.bodies(), positions.data(), poses);
    for (const auto& part : model.bodies().parts) add(part.part, poses[part.body] * part.body_T_part);
  }

  /// Depth [m] of every pixel, 0 where nothing is within `far_m`. Every `step`-th pixel is traced and copied
  /// to its neighbours.
  [[nodiscard]] std::vector<float> render(const CameraModel& camera, const Pose& root_T_camera, double far_m,
                                          int step = 1) const {
    std::vector<float> depth(static_cast<std::size_t>(camera.width) *
                             static_cast<std::size_t>(camera.height));
    for (int v = 0; v < camera.height; v += step)
      for (int u = 0; u < camera.width; u += step) {
        const float found = trace(camera.back_project(u, v, 1), root_T_camera, far_m);
        for (int y = v; y < std::min(v + step, camera.height); ++y)
          for (int x = u; x < std::min(u + step, camera.width); ++x)
            depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                  static_cast<std::size_t>(x)] = found;
      }
    return depth;
  }

 private:
  struct Solid {
    std::shared_ptr<const ConvexPart> part;
    Pose part_T_root;
  };

  [[nodiscard]] float trace(const Eigen::Vector3d& ray, const Pose& root_T_camera, double far_m) const {
    constexpr double kHit = 1e-4;
    const Eigen::Vector3d direction = root_T_camera.linear() * ray.normalized();
    double distance = 0;
    for (int i = 0; i < 300 && distance < far_m; ++i) {
      const Eigen::Vector3d point = root_T_camera.translation() + distance * direction;
      double smallest = far_m;
      for (const Solid& solid : solids_)
        smallest = std::min(smallest, distance_bound(*solid.part, solid.part_T_root * point));
      if (smallest < kHit) return static_cast<float>(distance / ray.norm());
      distance += smallest;
    }
    return 0;
  }

  std::vector<Solid> solids_;
};

inline CameraModel small_camera(int width = 160) {
  CameraModel camera;
  camera.width = width;
  camera.height = width * 3 / 4;
  camera.fx = camera.fy = 0.95 * width;
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

/// root_T_camera of a camera at `eye` that looks at `target`, level.
inline Pose looking(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose pose = Pose::Identity();
  pose.linear() << right, forward.cross(right), forward;
  pose.translation() = eye;
  return pose;
}

inline ImageView view_of(const std::vector<float>& depth, const CameraModel& camera) {
  return {reinterpret_cast<const std::uint8_t*>(depth.data()), camera.width, camera.height,
          4 * static_cast<std::size_t>(camera.width), PixelFormat::kDepth32M};
}

inline std::vector<std::uint16_t> in_millimetres(const std::vector<float>& depth) {
  std::vector<std::uint16_t> result;
  result.reserve(depth.size());
  for (const float metres : depth) result.push_back(static_cast<std::uint16_t>(std::lround(1000 * metres)));
  return result;
}

inline ImageView view_of(const std::vector<std::uint16_t>& depth, const CameraModel& camera) {
  return {reinterpret_cast<const std::uint8_t*>(depth.data()), camera.width, camera.height,
          2 * static_cast<std::size_t>(camera.width), PixelFormat::kDepth16Mm};
}

/// Both arms of Baxter.
inline const CollisionModel& both_arms() {
  static const CollisionModel model = [] {
    const auto robot =
        RobotModel::from_file(EXTPERFC_SOURCE_DIR "/urdf/mobile_baxter.urdf", EXTPERFC_SOURCE_DIR).value();
    const auto srdf = read_srdf(EXTPERFC_SOURCE_DIR "/config/robots/baxter/mobile_baxter.srdf").value();
    CollisionModelParams params;
    params.joints = joints_of_group(srdf, robot, "both_arms").value();
    params.allowed = allowed_pairs(srdf);
    return CollisionModel::make(robot, params).value();
  }();
  return model;
}

/// Both arms stretched forward and down a little, before the camera of the head.
inline JointVector reaching() {
  JointVector state(14);
  state << -0.08, -1.2, -1.19, 1.6, 0.67, 1.03, -0.5, 0.08, -1.2, 1.19, 1.6, -0.67, 1.03, 0.5;
  return state;
}

}  // namespace extperfc::arm::test
