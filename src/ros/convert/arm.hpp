#pragma once

#include <string>
#include <vector>

#include <extperfc/SceneObject.h>
#include <geometry_msgs/Pose.h>
#include <sensor_msgs/JointState.h>
#include <trajectory_msgs/JointTrajectory.h>

#include "extperfc/arm/robot_arms.hpp"
#include "extperfc/arm/timed_path.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

/// Messages of arms <-> the words of the core.
namespace extperfc::convert {

/// Errors: a quaternion that is no rotation (its norm is not 1 to 1 %), a value that is not finite. A
/// quaternion of zeros is one.
[[nodiscard]] Result<Pose> to_pose(const geometry_msgs::Pose& message);

/// Errors: counts of names and positions that differ, a name twice, a value that is not finite.
[[nodiscard]] Result<arm::JointPositions> to_positions(const sensor_msgs::JointState& message);
[[nodiscard]] sensor_msgs::JointState to_message(const arm::JointPositions& positions);

[[nodiscard]] trajectory_msgs::JointTrajectory to_message(const std::vector<std::string>& joints,
                                                          const std::vector<arm::TrajectoryPoint>& points);
/// Errors: those of TimedPath::make().
[[nodiscard]] Result<arm::TimedPath> to_path(const trajectory_msgs::JointTrajectory& message);

/// The primitives, then the meshes, in the object's frame. Errors: a primitive of an unknown type or with
/// sizes that are not positive, a mesh of no or more than 100,000 triangles or of vertices that it lacks,
/// counts of poses that do not fit.
[[nodiscard]] Result<std::vector<Shape>> to_shapes(const extperfc::SceneObject& message);
/// Fills primitives, meshes and their poses; meshes of files are left out.
void fill_shapes(const std::vector<Shape>& shapes, extperfc::SceneObject& message);

}  // namespace extperfc::convert
