// The part of PlanningScene for detected objects.
#include <algorithm>
#include <utility>

#include "ros/arm/planning_scene.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;

namespace {

/// For objects with one upright shape, as set_found() adds them.
bool same_size(const Geometry& a, const Geometry& b) {
  if (a.index() != b.index()) return false;
  if (const auto* box = std::get_if<Box>(&a)) return box->size_m == std::get<Box>(b).size_m;
  if (const auto* sphere = std::get_if<Sphere>(&a)) return sphere->radius_m == std::get<Sphere>(b).radius_m;
  if (const auto* tube = std::get_if<Cylinder>(&a)) {
    const auto& other = std::get<Cylinder>(b);
    return tube->radius_m == other.radius_m && tube->length_m == other.length_m;
  }
  if (const auto* cone = std::get_if<Cone>(&a)) {
    const auto& other = std::get<Cone>(b);
    return cone->radius_m == other.radius_m && cone->height_m == other.height_m;
  }
  return false;
}

bool same(const CollisionObject& a, const CollisionObject& b) {
  return a.label == b.label && a.frame == b.frame && a.frame_T_object.matrix() == b.frame_T_object.matrix() &&
         a.shapes.size() == 1 && b.shapes.size() == 1 &&
         same_size(a.shapes.front().geometry, b.shapes.front().geometry);
}

}  // namespace

/// True when set_found() must not change it; under mutex_.
bool PlanningScene::stays(const CollisionObject& item) const {
  return item.held || !item.found || holds_.count(item.name) > 0 || holds_.count(item.label) > 0;
}

tl::expected<bool, Status> PlanningScene::set_found(const std::vector<CollisionObject>& found) {
  const std::lock_guard lock(mutex_);
  Items items = items_;
  bool changed = false;
  for (auto item = items.begin(); item != items.end();) {
    const bool known = std::any_of(found.begin(), found.end(),
                                   [&](const CollisionObject& one) { return one.name == item->first; });
    changed = changed || (!known && !stays(item->second));
    item = known || stays(item->second) ? std::next(item) : items.erase(item);
  }
  for (const auto& one : found) {
    if (transforms_.is_link(one.name))
      return failure(ArmCode::kInvalidRequest, "a detected object has the name of the link " + one.name +
                                                   ": give the class another name");
    const auto known = items.find(one.name);
    if (known != items.end() && (stays(known->second) || same(known->second, one))) continue;
    items[one.name] = one;
    changed = true;
  }
  if (!changed) return false;
  if (items.size() > kMaxObjects)
    return failure(ArmCode::kInvalidRequest, "the scene would have more than " + std::to_string(kMaxObjects) +
                                                 " objects: remove some, or lower objects/max_objects");
  if (auto world = world_of(items); !world) return tl::unexpected(world.error());
  items_ = std::move(items);
  ++version_;
  return true;
}

std::vector<CollisionObject> PlanningScene::items() const {
  const std::lock_guard lock(mutex_);
  std::vector<CollisionObject> all;
  for (const auto& [name, item] : items_) {
    all.push_back(item);
    all.back().still = stays(item);
  }
  return all;
}

std::shared_ptr<const void> PlanningScene::hold(const std::string& name_or_label) {
  const std::lock_guard lock(mutex_);
  const auto entry = holds_.insert(name_or_label);
  return std::shared_ptr<const void>(&*entry, [this, entry](const void*) {
    const std::lock_guard own_lock(mutex_);
    holds_.erase(entry);
  });
}

}  // namespace extperfc::arm_node
