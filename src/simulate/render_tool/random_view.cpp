#include "simulate/render_tool/random_view.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/base/math.hpp"

namespace extperfc::simulate {

namespace {
constexpr double kWallGap = 0.35;  // between camera and the border of the floor plan [m]
constexpr int kTries = 30;

bool within(const WorldSpec& world, const Eigen::Vector3d& point) {
  const Eigen::Vector2d low = point.head<2>() - world.min_m;
  const Eigen::Vector2d high = world.max_m - point.head<2>();
  return std::min(low.minCoeff(), high.minCoeff()) > kWallGap && point.z() > 0.1 && point.z() < 2.4;
}

Eigen::Vector3d random_eye(Rng& rng, const Eigen::Vector3d& target, const ViewRange& range) {
  // Mostly from the robot's side, at -x, sometimes from anywhere.
  const double azimuth = rng.chance(0.7) ? rng.normal(kPi, 0.7) : rng.uniform(-kPi, kPi);
  const double elevation = rng.uniform(range.min_elevation_deg, range.max_elevation_deg) * kPi / 180;
  const double distance =
      range.min_distance_m + (range.max_distance_m - range.min_distance_m) * std::pow(rng.uniform(0, 1), 1.3);
  return target + distance * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
}

}  // namespace

Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, double roll_rad) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose pose = Pose::Identity();
  pose.linear() << right, forward.cross(right), forward;
  pose.translation() = eye;
  pose.rotate(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return pose;
}

CameraModel random_camera(Rng& rng, int width, int height) {
  // 615 px at 480 rows; other sizes are cut out and scaled.
  const double focal = 615.0 / 480.0 * height * rng.uniform(0.97, 1.03);
  const double cx = (width - 1) / 2.0 + width * rng.uniform(-0.01, 0.01);
  const double cy = (height - 1) / 2.0 + height * rng.uniform(-0.01, 0.01);
  return {width, height, focal, focal, cx, cy, {}};
}

std::vector<Eigen::Vector3d> targets_of(const WorldSpec& world, const std::vector<std::string>& classes) {
  std::vector<Eigen::Vector3d> targets;
  for (const BodySpec& body : world.bodies)
    if (std::find(classes.begin(), classes.end(), body.label) != classes.end())
      targets.emplace_back(body.world_T_body.translation());
  if (targets.empty()) targets.emplace_back(world.robot_start.x + 1, world.robot_start.y, 0.6);
  return targets;
}

Pose random_view(Rng& rng, const WorldSpec& world, const std::vector<Eigen::Vector3d>& targets,
                 const ViewRange& range) {
  const auto chosen = static_cast<std::size_t>(rng.integer(0, static_cast<int>(targets.size()) - 1));
  const Eigen::Vector3d& target = targets[chosen];
  Eigen::Vector3d eye(0, 0, 1.3);
  for (int attempt = 0; attempt < kTries; ++attempt) {
    eye = random_eye(rng, target, range);
    if (within(world, eye)) break;
  }
  const double spread = 0.12 * (eye - target).norm();
  const Eigen::Vector3d past{rng.normal(0, spread), rng.normal(0, spread), rng.normal(0, spread * 0.7)};
  return look_at(eye, target + past, rng.normal(0, range.roll_rad));
}

}  // namespace extperfc::simulate
