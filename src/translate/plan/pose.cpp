#include "translate/plan/pose.hpp"

#include <array>
#include <cstring>
#include <string_view>

namespace extperfc::translate {

namespace {

struct Vector {
  double x, y, z;
};
struct Quaternion {
  double x, y, z, w;
};
struct Pose {
  Vector position;
  Quaternion orientation;
};
static_assert(sizeof(Pose) == kPoseSize);

Pose load_pose(const std::uint8_t* bytes) {
  Pose pose{};
  std::memcpy(&pose, bytes, kPoseSize);
  auto& q = pose.orientation;
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) q.w = 1;
  return pose;
}

Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// v + 2 w (u x v) + 2 u x (u x v) with q = (u, w), for a unit quaternion.
Vector rotate(const Quaternion& q, const Vector& v) {
  const Vector u{q.x, q.y, q.z};
  const Vector once = cross(u, v);
  const Vector twice = cross(u, once);
  return {v.x + 2 * (q.w * once.x + twice.x), v.y + 2 * (q.w * once.y + twice.y),
          v.z + 2 * (q.w * once.z + twice.z)};
}

Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

bool is_identity(const Pose& pose) {
  const auto& [p, q] = pose;
  return p.x == 0 && p.y == 0 && p.z == 0 && q.x == 0 && q.y == 0 && q.z == 0 && (q.w == 1 || q.w == -1);
}

bool has_floats(const Field& field, std::string_view field_name, std::string_view names) {
  if (field.name != field_name || field.arity != Arity::kSingle || !field.message) return false;
  const auto& inner = field.message->fields();
  if (inner.size() != names.size()) return false;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (inner[i].name != names.substr(i, 1) || inner[i].primitive != Primitive::kFloat64 ||
        inner[i].arity != Arity::kSingle)
      return false;
  return true;
}

}  // namespace

bool is_pose(const MessageSchema& schema) {
  const auto& fields = schema.fields();
  return fields.size() == 2 && has_floats(fields[0], "position", "xyz") &&
         has_floats(fields[1], "orientation", "xyzw");
}

void compose_poses(const std::uint8_t* parent, const std::uint8_t* children, std::uint8_t* out,
                   std::size_t count) {
  const Pose outer = load_pose(parent);
  if (is_identity(outer)) {
    if (count != 0) std::memcpy(out, children, count * kPoseSize);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Pose inner = load_pose(children + i * kPoseSize);
    const Vector moved = rotate(outer.orientation, inner.position);
    const Vector& p = outer.position;
    const Pose result{{p.x + moved.x, p.y + moved.y, p.z + moved.z},
                      multiply(outer.orientation, inner.orientation)};
    std::memcpy(out + i * kPoseSize, &result, kPoseSize);
  }
}

}  // namespace extperfc::translate
