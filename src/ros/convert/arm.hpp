#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <extperfc/SceneObject.h>
#include <geometry_msgs/Pose.h>
#include <sensor_msgs/JointState.h>
#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/arm_code.hpp"
#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/arm/timed_path.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

/// Messages of arms <-> types of the core.
namespace extperfc::ros_convert {

/// A constant of extperfc/ArmCode.
[[nodiscard]] constexpr std::int32_t to_message(arm::ArmCode code) {
  return static_cast<std::int32_t>(code);
}

/// Errors: a quaternion whose norm differs from 1 by more than 1 % (e.g. all zeros), a value that is not
/// finite.
[[nodiscard]] Result<Pose> to_pose(const geometry_msgs::Pose& message);

/// Errors: counts of names and positions that differ, a name twice, a value that is not finite.
[[nodiscard]] Result<arm::JointPositions> to_positions(const sensor_msgs::JointState& message);
[[nodiscard]] sensor_msgs::JointState to_message(const arm::JointPositions& positions);

[[nodiscard]] trajectory_msgs::JointTrajectory to_message(const std::vector<std::string>& joints,
                                                          const std::vector<arm::TrajectoryPoint>& points);
/// Errors: those of TimedPath::make().
[[nodiscard]] Result<arm::TimedPath> to_path(const trajectory_msgs::JointTrajectory& message);

/// The primitives, then the meshes, in the object's frame. Errors: a primitive of an unknown type or with
/// sizes that are not positive, a mesh without or with more than 100,000 triangles, an invalid vertex index,
/// a wrong number of poses.
[[nodiscard]] Result<std::vector<Shape>> to_shapes(const extperfc::SceneObject& message);
/// Fills primitives, meshes and their poses; omits meshes of files.
void fill_shapes(const std::vector<Shape>& shapes, extperfc::SceneObject& message);

}  // namespace extperfc::ros_convert
