#include "ros/convert/arm.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include <extperfc/ArmCode.h>

#include "ros/convert/geometry.hpp"

namespace extperfc::ros_convert {

namespace {

using shape_msgs::SolidPrimitive;

static_assert(to_message(arm::ArmCode::kSuccess) == extperfc::ArmCode::SUCCESS);
static_assert(to_message(arm::ArmCode::kInvalidRequest) == extperfc::ArmCode::INVALID_REQUEST);
static_assert(to_message(arm::ArmCode::kStartOutsideLimits) == extperfc::ArmCode::START_OUTSIDE_LIMITS);
static_assert(to_message(arm::ArmCode::kStartInCollision) == extperfc::ArmCode::START_IN_COLLISION);
static_assert(to_message(arm::ArmCode::kGoalOutsideLimits) == extperfc::ArmCode::GOAL_OUTSIDE_LIMITS);
static_assert(to_message(arm::ArmCode::kGoalInCollision) == extperfc::ArmCode::GOAL_IN_COLLISION);
static_assert(to_message(arm::ArmCode::kPlanningTimeout) == extperfc::ArmCode::PLANNING_TIMEOUT);
static_assert(to_message(arm::ArmCode::kCancelled) == extperfc::ArmCode::CANCELLED);
static_assert(to_message(arm::ArmCode::kGoalUnreachable) == extperfc::ArmCode::GOAL_UNREACHABLE);
static_assert(to_message(arm::ArmCode::kUnknownFrame) == extperfc::ArmCode::UNKNOWN_FRAME);
static_assert(to_message(arm::ArmCode::kNoJointStates) == extperfc::ArmCode::NO_JOINT_STATES);
static_assert(to_message(arm::ArmCode::kConstraintViolated) == extperfc::ArmCode::CONSTRAINT_VIOLATED);
static_assert(to_message(arm::ArmCode::kPathIncomplete) == extperfc::ArmCode::PATH_INCOMPLETE);
static_assert(to_message(arm::ArmCode::kPathBlocked) == extperfc::ArmCode::PATH_BLOCKED);
static_assert(to_message(arm::ArmCode::kNotFollowing) == extperfc::ArmCode::NOT_FOLLOWING);
static_assert(to_message(arm::ArmCode::kControllerRefused) == extperfc::ArmCode::CONTROLLER_REFUSED);
static_assert(to_message(arm::ArmCode::kControllerMissing) == extperfc::ArmCode::CONTROLLER_MISSING);
static_assert(to_message(arm::ArmCode::kRobotNotEnabled) == extperfc::ArmCode::ROBOT_NOT_ENABLED);
static_assert(to_message(arm::ArmCode::kRobotStopped) == extperfc::ArmCode::ROBOT_STOPPED);
static_assert(to_message(arm::ArmCode::kPreempted) == extperfc::ArmCode::PREEMPTED);
static_assert(to_message(arm::ArmCode::kStartMoved) == extperfc::ArmCode::START_MOVED);
static_assert(to_message(arm::ArmCode::kUnknownObject) == extperfc::ArmCode::UNKNOWN_OBJECT);
static_assert(to_message(arm::ArmCode::kNoGrasp) == extperfc::ArmCode::NO_GRASP);
static_assert(to_message(arm::ArmCode::kGraspMissed) == extperfc::ArmCode::GRASP_MISSED);
static_assert(to_message(arm::ArmCode::kObjectLost) == extperfc::ArmCode::OBJECT_LOST);
static_assert(to_message(arm::ArmCode::kNothingHeld) == extperfc::ArmCode::NOTHING_HELD);
static_assert(to_message(arm::ArmCode::kGrippersFull) == extperfc::ArmCode::GRIPPERS_FULL);
static_assert(to_message(arm::ArmCode::kGripperFailed) == extperfc::ArmCode::GRIPPER_FAILED);
static_assert(to_message(arm::ArmCode::kNotReleased) == extperfc::ArmCode::NOT_RELEASED);
static_assert(to_message(arm::ArmCode::kInternal) == extperfc::ArmCode::INTERNAL);

constexpr std::size_t kMaxTriangles = 100'000;  ///< of one mesh

Result<Geometry> to_geometry(const SolidPrimitive& primitive) {
  const auto& size = primitive.dimensions;
  const auto has = [&](std::size_t count) {
    if (size.size() != count) return false;
    for (const double value : size)
      if (!(value > 0.0) || !std::isfinite(value)) return false;
    return true;
  };
  switch (primitive.type) {
    case SolidPrimitive::BOX:
      if (has(3)) return Box{{size[0], size[1], size[2]}};
      return fail(ErrorCode::kInvalidArgument, "a box needs three lengths above 0 m");
    case SolidPrimitive::SPHERE:
      if (has(1)) return Sphere{size[0]};
      return fail(ErrorCode::kInvalidArgument, "a sphere needs a radius above 0 m");
    case SolidPrimitive::CYLINDER:
      if (has(2))
        return Cylinder{size[SolidPrimitive::CYLINDER_RADIUS], size[SolidPrimitive::CYLINDER_HEIGHT]};
      return fail(ErrorCode::kInvalidArgument, "a cylinder needs a height and a radius above 0 m");
    case SolidPrimitive::CONE:
      if (has(2)) return Cone{size[SolidPrimitive::CONE_RADIUS], size[SolidPrimitive::CONE_HEIGHT]};
      return fail(ErrorCode::kInvalidArgument, "a cone needs a height and a radius above 0 m");
    default:
      return fail(ErrorCode::kInvalidArgument,
                  "unknown type " + std::to_string(primitive.type) + " of shape_msgs/SolidPrimitive");
  }
}

std::optional<SolidPrimitive> to_primitive(const Geometry& geometry) {
  SolidPrimitive primitive;
  if (const auto* box = std::get_if<Box>(&geometry)) {
    primitive.type = SolidPrimitive::BOX;
    primitive.dimensions = {box->size_m.x(), box->size_m.y(), box->size_m.z()};
  } else if (const auto* sphere = std::get_if<Sphere>(&geometry)) {
    primitive.type = SolidPrimitive::SPHERE;
    primitive.dimensions = {sphere->radius_m};
  } else if (const auto* cylinder = std::get_if<Cylinder>(&geometry)) {
    primitive.type = SolidPrimitive::CYLINDER;
    primitive.dimensions = {cylinder->length_m, cylinder->radius_m};
  } else if (const auto* cone = std::get_if<Cone>(&geometry)) {
    primitive.type = SolidPrimitive::CONE;
    primitive.dimensions = {cone->height_m, cone->radius_m};
  } else {
    return std::nullopt;
  }
  return primitive;
}

Result<Geometry> to_geometry(const shape_msgs::Mesh& mesh) {
  if (mesh.triangles.empty() || mesh.triangles.size() > kMaxTriangles)
    return fail(ErrorCode::kInvalidArgument, "a mesh has from 1 to " + std::to_string(kMaxTriangles) +
                                                 " triangles, not " + std::to_string(mesh.triangles.size()));
  auto triangles = std::make_shared<std::vector<Triangle>>();
  triangles->reserve(mesh.triangles.size());
  for (const auto& corners : mesh.triangles) {
    Triangle triangle;
    for (std::size_t i = 0; i < triangle.size(); ++i) {
      const std::size_t index = corners.vertex_indices[i];
      if (index >= mesh.vertices.size())
        return fail(ErrorCode::kInvalidArgument, "a triangle of a mesh has the vertex index " +
                                                     std::to_string(index) + ", of " +
                                                     std::to_string(mesh.vertices.size()));
      const auto& at = mesh.vertices[index];
      triangle[i] = Eigen::Vector3d(at.x, at.y, at.z).cast<float>();
    }
    triangles->push_back(triangle);
  }
  return TriangleMesh{"in the message", Eigen::Vector3d::Ones(), std::move(triangles)};
}

shape_msgs::Mesh to_mesh(const std::vector<Triangle>& triangles) {
  shape_msgs::Mesh mesh;
  std::map<std::array<float, 3>, std::uint32_t> known;
  for (const auto& triangle : triangles) {
    shape_msgs::MeshTriangle corners;
    for (std::size_t i = 0; i < triangle.size(); ++i) {
      const Eigen::Vector3f& at = triangle[i];
      const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      const auto [place, is_new] = known.try_emplace({at.x(), at.y(), at.z()}, next);
      if (is_new) mesh.vertices.push_back(to_point(at.cast<double>()));
      corners.vertex_indices[i] = place->second;
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

/// Adds the shapes of one kind. Poses: none, or one for each.
template <typename Message>
Result<void> add_shapes(const std::vector<Message>& messages, const std::vector<geometry_msgs::Pose>& poses,
                        const char* kind, std::vector<Shape>& shapes) {
  if (!poses.empty() && poses.size() != messages.size())
    return fail(ErrorCode::kInvalidArgument, std::to_string(messages.size()) + " " + kind + " have " +
                                                 std::to_string(poses.size()) + " poses");
  for (std::size_t i = 0; i < messages.size(); ++i) {
    auto geometry = to_geometry(messages[i]);
    if (!geometry) return tl::unexpected(geometry.error());
    Shape shape;
    shape.geometry = std::move(*geometry);
    if (!poses.empty()) {
      const auto pose = to_pose(poses[i]);
      if (!pose) return tl::unexpected(pose.error());
      shape.body_T_shape = *pose;
    }
    shapes.push_back(std::move(shape));
  }
  return {};
}

arm::JointVector to_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

Result<Pose> to_pose(const geometry_msgs::Pose& message) {
  const Eigen::Vector3d position(message.position.x, message.position.y, message.position.z);
  const Eigen::Quaterniond rotation(message.orientation.w, message.orientation.x, message.orientation.y,
                                    message.orientation.z);
  if (!position.allFinite() || !rotation.coeffs().allFinite())
    return fail(ErrorCode::kInvalidArgument, "the pose has a value that is not finite");
  if (std::abs(rotation.norm() - 1.0) > 0.01)
    return fail(ErrorCode::kInvalidArgument, "the quaternion of the pose must be normalized: its norm is " +
                                                 std::to_string(rotation.norm()));
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

Result<arm::JointPositions> to_positions(const sensor_msgs::JointState& message) {
  if (message.name.size() != message.position.size())
    return fail(ErrorCode::kInvalidArgument, std::to_string(message.name.size()) + " joints have " +
                                                 std::to_string(message.position.size()) + " positions");
  arm::JointPositions positions;
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    if (!std::isfinite(message.position[i]))
      return fail(ErrorCode::kInvalidArgument, "the position of " + message.name[i] + " is not finite");
    if (!positions.emplace(message.name[i], message.position[i]).second)
      return fail(ErrorCode::kInvalidArgument, "joint " + message.name[i] + " is named twice");
  }
  return positions;
}

sensor_msgs::JointState to_message(const arm::JointPositions& positions) {
  sensor_msgs::JointState message;
  for (const auto& [name, value] : positions) {
    message.name.push_back(name);
    message.position.push_back(value);
  }
  return message;
}

trajectory_msgs::JointTrajectory to_message(const std::vector<std::string>& joints,
                                            const std::vector<arm::TrajectoryPoint>& points) {
  trajectory_msgs::JointTrajectory message;
  message.joint_names = joints;
  for (const auto& point : points) {
    trajectory_msgs::JointTrajectoryPoint out;
    out.positions.assign(point.position.begin(), point.position.end());
    out.velocities.assign(point.velocity.begin(), point.velocity.end());
    out.time_from_start = ros::Duration(point.time_s);
    message.points.push_back(std::move(out));
  }
  return message;
}

Result<arm::TimedPath> to_path(const trajectory_msgs::JointTrajectory& message) {
  std::vector<arm::TrajectoryPoint> points;
  for (const auto& point : message.points) {
    if (point.positions.size() > arm::kMaxJoints || point.velocities.size() > arm::kMaxJoints)
      return fail(ErrorCode::kInvalidArgument,
                  "a trajectory has at most " + std::to_string(arm::kMaxJoints) + " joints");
    points.push_back(
        {point.time_from_start.toSec(), to_vector(point.positions), to_vector(point.velocities), {}});
  }
  return arm::TimedPath::make(message.joint_names, std::move(points));
}

Result<std::vector<Shape>> to_shapes(const extperfc::SceneObject& message) {
  std::vector<Shape> shapes;
  if (auto done = add_shapes(message.primitives, message.primitive_poses, "primitives", shapes); !done)
    return tl::unexpected(done.error());
  if (auto done = add_shapes(message.meshes, message.mesh_poses, "meshes", shapes); !done)
    return tl::unexpected(done.error());
  return shapes;
}

void fill_shapes(const std::vector<Shape>& shapes, extperfc::SceneObject& message) {
  for (const auto& shape : shapes) {
    if (const auto* mesh = std::get_if<TriangleMesh>(&shape.geometry); mesh != nullptr && mesh->triangles) {
      message.meshes.push_back(to_mesh(*mesh->triangles));
      message.mesh_poses.push_back(to_message(shape.body_T_shape));
    } else if (const auto primitive = to_primitive(shape.geometry)) {
      message.primitives.push_back(*primitive);
      message.primitive_poses.push_back(to_message(shape.body_T_shape));
    }
  }
}

}  // namespace extperfc::ros_convert
