#include "extperfc/simulate/sensor_rig.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "extperfc/base/math.hpp"

#include "simulate/render/camera.hpp"
#include "simulate/render/lidar.hpp"
#include "simulate/render/scene.hpp"
#include "simulate/render/stage.hpp"

namespace extperfc::simulate {

namespace {

/// Where everything stands before the first snapshot.
Snapshot first_snapshot(const RobotModel& robot, const WorldSpec& world) {
  Snapshot snapshot;
  const Pose world_T_root = to_pose(world.robot_start);
  snapshot.world_T_link = robot.link_poses(std::vector<double>(robot.joints().size(), 0.0));
  for (auto& pose : snapshot.world_T_link) pose = world_T_root * pose;
  for (const auto& body : world.bodies) snapshot.world_T_body.push_back(body.world_T_body);
  for (const auto& person : world.people) {
    const Eigen::Vector2d at = person.path_m.empty() ? Eigen::Vector2d::Zero() : person.path_m.front();
    snapshot.world_T_person.push_back({at.x(), at.y(), 0.0});
  }
  return snapshot;
}

class RayCastRig final : public SensorRig {
 public:
  RayCastRig(Scene scene, const LightSpec& light, std::uint64_t seed)
      : scene_(std::move(scene)), light_(light), seed_(seed) {}

  void pose(const Snapshot& snapshot) override {
    time_s_ = snapshot.time_s;
    scene_.pose(snapshot);
  }

  void camera(const CameraParams& params, const Pose& world_T_optical, CameraImages& images) override {
    camera_.render(params, world_T_optical, scene_, light_, seed_, time_s_, images);
  }

  void lidar(const LidarParams& params, const Pose& world_T_begin, const Pose& world_T_end,
             std::vector<LidarPoint>& points) override {
    lidar_.sweep(params, world_T_begin, world_T_end, scene_, seed_, time_s_, points);
  }

  [[nodiscard]] double range(const Pose& world_T_sensor, double half_angle_rad, double max_m) override;

  [[nodiscard]] const std::vector<Instance>& instances() const override { return scene_.instances(); }
  [[nodiscard]] std::size_t triangles() const override { return scene_.triangles(); }
  [[nodiscard]] const char* engine() const override { return scene_.rays().name(); }

 private:
  Scene scene_;
  LightSpec light_;
  std::uint64_t seed_;
  double time_s_{0};
  Camera camera_;
  Lidar lidar_;
};

double RayCastRig::range(const Pose& world_T_sensor, double half_angle_rad, double max_m) {
  constexpr int kRays = 9;  // the axis and eight on the cone
  RayPacket packet{};
  clear(packet.ray);
  clear(packet.hit);
  LaneMask active{};
  for (int k = 0; k < kRays; ++k) {
    const double off_axis = k == 0 ? 0.0 : half_angle_rad;
    const double around = k * kPi / 4.0;
    const Eigen::Vector3d direction =
        world_T_sensor.linear() * Eigen::Vector3d(std::cos(off_axis), std::sin(off_axis) * std::cos(around),
                                                  std::sin(off_axis) * std::sin(around));
    packet.ray.org_x[k] = static_cast<float>(world_T_sensor.translation().x());
    packet.ray.org_y[k] = static_cast<float>(world_T_sensor.translation().y());
    packet.ray.org_z[k] = static_cast<float>(world_T_sensor.translation().z());
    packet.ray.dir_x[k] = static_cast<float>(direction.x());
    packet.ray.dir_y[k] = static_cast<float>(direction.y());
    packet.ray.dir_z[k] = static_cast<float>(direction.z());
    packet.ray.near[k] = 0.001F;
    packet.ray.far[k] = static_cast<float>(max_m);
    active.on[k] = -1;
  }
  scene_.rays().intersect(active, false, packet);
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kRays; ++k)
    if (packet.hit.mesh_instance[k] != kNoHit)
      nearest = std::min(nearest, static_cast<double>(packet.ray.far[k]));
  return nearest;
}

}  // namespace

Result<std::unique_ptr<SensorRig>> SensorRig::make(const RobotModel& robot, const WorldSpec& world,
                                                   std::uint64_t seed) {
  auto stage = build_stage(robot, world);
  if (!stage) return tl::unexpected(stage.error());
  auto rays = RayScene::make();
  if (!rays)
    return fail(ErrorCode::kUnsupported, "Embree does not run on this processor: the simulator needs it");
  Scene scene(std::move(*stage), std::move(rays));
  scene.pose(first_snapshot(robot, world));
  return std::make_unique<RayCastRig>(std::move(scene), world.light, seed);
}

}  // namespace extperfc::simulate
