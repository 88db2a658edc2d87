#include "world/robot/urdf_convert.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "world/robot/mesh_resource.hpp"

namespace extperfc {

namespace {

namespace fs = std::filesystem;

constexpr float kPaintGloss = 0.25F;  // URDF has no element for it: painted plastic and metal shine a little
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector3d to_vector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

Pose to_pose(const urdf::Pose& pose) {
  Pose result = Pose::Identity();
  result.translation() = to_vector(pose.position);
  const urdf::Rotation& r = pose.rotation;
  result.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  return result;
}

Result<Geometry> to_mesh(const urdf::Mesh& mesh, const fs::path& resource_root) {
  auto path = find_mesh(mesh.filename, resource_root);
  if (!path) return tl::unexpected<Error>(path.error());
  const Eigen::Vector3d scale = to_vector(mesh.scale);
  if (!(scale.array().abs() > 0).all())
    return fail(ErrorCode::kInvalidArgument, "mesh '" + mesh.filename + "' has a scale of 0");
  return TriangleMesh{*std::move(path), scale};
}

/// A box, cylinder or sphere.
Geometry to_primitive(const urdf::Geometry& geometry) {
  if (geometry.type == urdf::Geometry::BOX)
    return Box{to_vector(static_cast<const urdf::Box&>(geometry).dim)};
  if (geometry.type == urdf::Geometry::SPHERE)
    return Sphere{static_cast<const urdf::Sphere&>(geometry).radius};
  const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
  return Cylinder{cylinder.radius, cylinder.length};
}

bool has_size(const Geometry& geometry) {
  if (const auto* box = std::get_if<Box>(&geometry)) return (box->size_m.array() > 0).all();
  if (const auto* sphere = std::get_if<Sphere>(&geometry)) return sphere->radius_m > 0;
  const auto* cylinder = std::get_if<Cylinder>(&geometry);
  return cylinder == nullptr || (cylinder->radius_m > 0 && cylinder->length_m > 0);
}

Result<Shape> to_shape(const urdf::Geometry* geometry, const urdf::Pose& origin, const fs::path& root) {
  if (geometry == nullptr)
    return fail(ErrorCode::kCorrupt, "a <visual> or <collision> without <geometry>: add one");
  Shape shape;
  shape.body_T_shape = to_pose(origin);
  if (geometry->type == urdf::Geometry::MESH) {
    auto mesh = to_mesh(static_cast<const urdf::Mesh&>(*geometry), root);
    if (!mesh) return tl::unexpected<Error>(mesh.error());
    shape.geometry = *std::move(mesh);
  } else {
    shape.geometry = to_primitive(*geometry);
  }
  if (!has_size(shape.geometry))
    return fail(ErrorCode::kInvalidArgument, "a shape whose size is not above 0: correct it or remove it");
  return shape;
}

Result<void> add_shapes(const urdf::Link& link, const fs::path& root, Link& result) {
  for (const auto& visual : link.visual_array) {
    auto shape = to_shape(visual->geometry.get(), visual->origin, root);
    if (!shape) return tl::unexpected<Error>(shape.error());
    shape->material.gloss = kPaintGloss;
    if (const auto& material = visual->material)
      shape->material.colour = {material->color.r, material->color.g, material->color.b};
    result.visuals.push_back(*std::move(shape));
  }
  for (const auto& collision : link.collision_array) {
    auto shape = to_shape(collision->geometry.get(), collision->origin, root);
    if (!shape) return tl::unexpected<Error>(shape.error());
    result.collisions.push_back(*std::move(shape));
  }
  return {};
}

Result<Inertial> to_inertial(const urdf::Inertial& inertial) {
  Inertial result;
  result.mass_kg = inertial.mass;
  result.link_T_com = to_pose(inertial.origin);
  result.inertia_kg_m2 << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz,
      inertial.ixz, inertial.iyz, inertial.izz;
  if (!(result.mass_kg >= 0))
    return fail(ErrorCode::kInvalidArgument, "mass " + std::to_string(inertial.mass) + " kg: write one >= 0");
  if (!(result.inertia_kg_m2.diagonal().array() >= 0).all())
    return fail(ErrorCode::kInvalidArgument, "negative moment of inertia: ixx, iyy and izz must be >= 0");
  return result;
}

Error in(const std::string& what, const std::string& name, const Error& error) {
  return {error.code, what + " '" + name + "': " + error.message};
}

Result<JointType> to_type(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::FIXED:
      return JointType::kFixed;
    case urdf::Joint::REVOLUTE:
      return JointType::kRevolute;
    case urdf::Joint::CONTINUOUS:
      return JointType::kContinuous;
    case urdf::Joint::PRISMATIC:
      return JointType::kPrismatic;
    default:
      return fail(ErrorCode::kUnsupported,
                  "its type is floating or planar: use fixed, revolute, continuous or prismatic");
  }
}

Result<void> add_limits(const urdf::Joint& joint, Joint& result) {
  if (joint.limits) {
    result.lower = joint.limits->lower;
    result.upper = joint.limits->upper;
    result.max_velocity = joint.limits->velocity;
    result.max_effort = joint.limits->effort;
  }
  if (result.type == JointType::kContinuous) {
    result.lower = -kInfinity;
    result.upper = kInfinity;
  }
  if (!(result.lower <= result.upper))
    return fail(ErrorCode::kInvalidArgument, "lower limit " + std::to_string(result.lower) +
                                                 " is above the upper limit " + std::to_string(result.upper) +
                                                 ": swap them");
  if (!(result.max_velocity >= 0) || !(result.max_effort >= 0))
    return fail(ErrorCode::kInvalidArgument, "a limit of velocity or effort is below 0: write its size");
  return {};
}

Result<void> add_motion(const urdf::Joint& joint, Joint& result) {
  auto type = to_type(joint);
  if (!type) return tl::unexpected<Error>(type.error());
  result.type = *type;
  if (result.type == JointType::kFixed) return {};
  const Eigen::Vector3d axis = to_vector(joint.axis);
  if (!(axis.norm() > 1e-6))
    return fail(ErrorCode::kInvalidArgument, "its axis is 0: write a direction, e.g. \"0 0 1\"");
  result.axis = axis.normalized();
  return add_limits(joint, result);
}

}  // namespace

Result<Link> to_link(const urdf::Link& link, const fs::path& resource_root) {
  Link result;
  result.name = link.name;
  if (link.inertial) {
    auto inertial = to_inertial(*link.inertial);
    if (!inertial) return tl::unexpected<Error>(in("link", link.name, inertial.error()));
    result.inertial = *std::move(inertial);
  }
  if (const auto added = add_shapes(link, resource_root, result); !added)
    return tl::unexpected<Error>(in("link", link.name, added.error()));
  return result;
}

Result<Joint> to_joint(const urdf::Joint& joint) {
  Joint result;
  result.name = joint.name;
  result.parent_T_joint = to_pose(joint.parent_to_joint_origin_transform);
  if (const auto added = add_motion(joint, result); !added)
    return tl::unexpected<Error>(in("joint", joint.name, added.error()));
  return result;
}

}  // namespace extperfc
