#include "extperfc/scan/level.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace extperfc::scan {

namespace {

Eigen::Matrix3d heading_of(const Eigen::Matrix3d& world_R_body) {
  constexpr double kStraightUp = 1e-6;  // horizontal part of the x axis
  if (world_R_body.col(0).head<2>().norm() < kStraightUp) return Eigen::Matrix3d::Identity();
  const double heading = std::atan2(world_R_body(1, 0), world_R_body(0, 0));
  return Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

Eigen::Matrix3d tilt_of(const Eigen::Matrix3d& world_R_body) {
  return heading_of(world_R_body).transpose() * world_R_body;
}

Pose upright(const Pose& world_T_body) {
  Pose pose = world_T_body;
  pose.linear() = heading_of(world_T_body.linear());
  return pose;
}

Pose with_tilt(const Pose& world_T_body, const Eigen::Matrix3d& world_R_tilted) {
  Pose pose = world_T_body;
  pose.linear() = heading_of(world_T_body.linear()) * tilt_of(world_R_tilted);
  return pose;
}

double tilt_angle_rad(const Eigen::Matrix3d& world_R_body) {
  return std::acos(std::clamp(world_R_body(2, 2), -1.0, 1.0));
}

}  // namespace extperfc::scan
