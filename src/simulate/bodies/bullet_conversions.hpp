#pragma once

#include <Eigen/Core>
#include <LinearMath/btTransform.h>

#include "extperfc/world/pose.hpp"

namespace extperfc::simulate {

[[nodiscard]] inline btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

[[nodiscard]] inline Eigen::Vector3d from_bullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

[[nodiscard]] inline btMatrix3x3 to_bullet(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

[[nodiscard]] inline btTransform to_bullet(const Pose& pose) {
  return btTransform(to_bullet(Eigen::Matrix3d(pose.linear())),
                     to_bullet(Eigen::Vector3d(pose.translation())));
}

[[nodiscard]] inline Pose from_bullet(const btTransform& transform) {
  Pose pose = Pose::Identity();
  const btMatrix3x3& basis = transform.getBasis();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = basis[row][column];
  pose.translation() = from_bullet(transform.getOrigin());
  return pose;
}

}  // namespace extperfc::simulate
