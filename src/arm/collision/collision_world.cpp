#include "extperfc/arm/collision_world.hpp"

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {
namespace {

Result<Parts> parts_of(const std::string& name, const std::vector<Shape>& shapes, const Pose& pose) {
  if (name.empty()) return fail(ErrorCode::kInvalidArgument, "an object needs a name");
  if (shapes.empty()) return fail(ErrorCode::kInvalidArgument, "object " + name + " has no shapes");
  if (!pose.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, "the pose of object " + name + " is not finite");
  return make_convex_parts("object " + name, shapes);
}

}  // namespace

Result<void> CollisionWorld::add(const WorldObject& object) {
  auto parts = parts_of(object.name, object.shapes, object.root_T_object);
  if (!parts) return tl::unexpected<Error>(parts.error());
  remove(object.name);
  objects_[object.name] = std::make_shared<const Placed>(Placed{object, std::move(*parts)});
  return {};
}

Result<void> CollisionWorld::attach(const AttachedObject& object) {
  auto parts = parts_of(object.name, object.shapes, object.link_T_object);
  if (!parts) return tl::unexpected<Error>(parts.error());
  remove(object.name);
  attached_[object.name] = std::make_shared<const Carried>(Carried{object, std::move(*parts)});
  return {};
}

Result<void> CollisionWorld::move(const std::string& name, const Pose& root_T_object) {
  const auto found = objects_.find(name);
  if (found == objects_.end()) return fail(ErrorCode::kNotFound, "the world has no object " + name);
  if (!root_T_object.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, "the pose of object " + name + " is not finite");
  Placed moved = *found->second;
  moved.object.root_T_object = root_T_object;
  found->second = std::make_shared<const Placed>(std::move(moved));
  return {};
}

bool CollisionWorld::remove(const std::string& name) {
  return objects_.erase(name) + attached_.erase(name) > 0;
}

void CollisionWorld::clear() {
  objects_.clear();
  attached_.clear();
}

}  // namespace extperfc::arm
