// The part of SceneKeeper that concerns detected things.
#include <algorithm>
#include <utility>

#include "ros/arm/scene_keeper.hpp"

namespace extperfc::arm_node {

using arm::ArmCode;

namespace {

/// Of things with one standing shape, as set_found() puts them in.
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

bool same(const SceneItem& a, const SceneItem& b) {
  return a.label == b.label && a.frame == b.frame && a.frame_T_object.matrix() == b.frame_T_object.matrix() &&
         a.shapes.size() == 1 && b.shapes.size() == 1 &&
         same_size(a.shapes.front().geometry, b.shapes.front().geometry);
}

}  // namespace

/// Whether set_found() leaves it alone; under mutex_.
bool SceneKeeper::stays(const SceneItem& item) const {
  return item.held || !item.found || holds_.count(item.name) > 0 || holds_.count(item.label) > 0;
}

tl::expected<bool, Ending> SceneKeeper::set_found(const std::vector<SceneItem>& found) {
  const std::lock_guard lock(mutex_);
  Items items = items_;
  bool changed = false;
  for (auto item = items.begin(); item != items.end();) {
    const bool known = std::any_of(found.begin(), found.end(),
                                   [&](const SceneItem& one) { return one.name == item->first; });
    changed = changed || (!known && !stays(item->second));
    item = known || stays(item->second) ? std::next(item) : items.erase(item);
  }
  for (const auto& one : found) {
    if (frames_.is_link(one.name))
      return end(ArmCode::kInvalidRequest, "a link of the robot is called " + one.name +
                                               " like a detected object: give the class another name");
    const auto known = items.find(one.name);
    if (known != items.end() && (stays(known->second) || same(known->second, one))) continue;
    items[one.name] = one;
    changed = true;
  }
  if (!changed) return false;
  if (items.size() > kMostObjects)
    return end(ArmCode::kInvalidRequest, "the scene would have more than " + std::to_string(kMostObjects) +
                                             " objects: remove some, or lower objects/most_objects");
  if (auto world = world_of(items); !world) return tl::unexpected(world.error());
  items_ = std::move(items);
  ++version_;
  return true;
}

std::vector<SceneItem> SceneKeeper::items() const {
  const std::lock_guard lock(mutex_);
  std::vector<SceneItem> all;
  for (const auto& [name, item] : items_) {
    all.push_back(item);
    all.back().still = stays(item);
  }
  return all;
}

std::shared_ptr<const void> SceneKeeper::hold(const std::string& name_or_label) {
  const std::lock_guard lock(mutex_);
  const auto entry = holds_.insert(name_or_label);
  return std::shared_ptr<const void>(&*entry, [this, entry](const void*) {
    const std::lock_guard own_lock(mutex_);
    holds_.erase(entry);
  });
}

}  // namespace extperfc::arm_node
