#include "ros/arm/planning_scene.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "ros/convert/arm.hpp"
#include "ros/convert/geometry.hpp"
#include "ros/convert/shape_marker.hpp"

namespace extperfc::ros_arm {

using arm::ArmCode;
using extperfc::SceneObject;

namespace {

tl::expected<CollisionObject*, Status> known(std::map<std::string, CollisionObject>& items,
                                             const std::string& name) {
  const auto found = items.find(name);
  if (found == items.end())
    return failure(ArmCode::kUnknownObject, "there is no object '" + name + "' in the scene");
  return &found->second;
}

bool removes_all(const SceneObject& message) {
  return message.operation == SceneObject::REMOVE && message.name.empty();
}

void set_color(visualization_msgs::Marker& marker, float red, float green, float blue) {
  marker.color.r = red;
  marker.color.g = green;
  marker.color.b = blue;
  marker.color.a = 0.75F;
}

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

tl::expected<void, Status> PlanningScene::apply(const std::vector<SceneObject>& objects) {
  const std::lock_guard lock(mutex_);
  Items items = items_;
  for (const auto& object : objects)
    if (auto done = change(object, items); !done)
      return failure(done.error().code, "object '" + object.name + "': " + done.error().message);
  if (items.size() > kMaxObjects)
    return failure(ArmCode::kInvalidRequest,
                   "the scene would have more than " + std::to_string(kMaxObjects) + " objects: remove some");
  if (auto world = world_of(items); !world) return tl::unexpected(world.error());
  items_ = std::move(items);
  if (std::any_of(objects.begin(), objects.end(), removes_all)) seen_.clear();
  ++version_;
  return {};
}

tl::expected<void, Status> PlanningScene::change(const SceneObject& message, Items& items) const {
  if (removes_all(message)) {
    items.clear();
    return {};
  }
  if (message.name.empty()) return failure(ArmCode::kInvalidRequest, "an object needs a name");
  switch (message.operation) {
    case SceneObject::ADD:
      return add(message, items);
    case SceneObject::REMOVE:
      if (items.erase(message.name) > 0) return {};
      return failure(ArmCode::kUnknownObject, "it is not in the scene");
    case SceneObject::MOVE: {
      auto item = known(items, message.name);
      if (!item) return tl::unexpected(item.error());
      const auto pose = transforms_.root_T_pose(message.pose);
      if (!pose) return tl::unexpected(pose.error());
      (*item)->held = false;
      return place(*pose, **item);
    }
    case SceneObject::ATTACH:
      return attach(message, items);
    case SceneObject::DETACH:
      return detach(message.name, items);
    default:
      return failure(ArmCode::kInvalidRequest,
                     "operation " + std::to_string(message.operation) + " is unknown");
  }
}

/// Stores the pose of an object that stands still.
tl::expected<void, Status> PlanningScene::place(const Pose& root_T_object, CollisionObject& item) const {
  const auto root_T_world = transforms_.root_T_frame(world_frame_, ros::Time());
  item.frame = root_T_world ? world_frame_ : "";  // without such a frame the robot is assumed not to drive
  item.frame_T_object = root_T_world ? root_T_world->inverse() * root_T_object : root_T_object;
  return {};
}

tl::expected<void, Status> PlanningScene::add(const SceneObject& message, Items& items) const {
  if (transforms_.is_link(message.name))
    return failure(ArmCode::kInvalidRequest, "a link of the robot has this name");
  if (message.name == kSeenName)
    return failure(ArmCode::kInvalidRequest, "this name is reserved for what the depth camera sees");
  auto shapes = ros_convert::to_shapes(message);
  if (!shapes) return failure(ArmCode::kInvalidRequest, shapes.error().message);
  if (shapes->empty()) return failure(ArmCode::kInvalidRequest, "it has no shapes");
  const auto pose = transforms_.root_T_pose(message.pose);
  if (!pose) return tl::unexpected(pose.error());
  CollisionObject item;
  item.name = message.name;
  item.label = message.label;
  item.shapes = std::move(*shapes);
  if (auto placed = place(*pose, item); !placed) return placed;
  items[message.name] = std::move(item);
  return {};
}

tl::expected<void, Status> PlanningScene::attach(const SceneObject& message, Items& items) const {
  if (!transforms_.is_link(message.link))
    return failure(ArmCode::kInvalidRequest, "'" + message.link + "' is not a link of the robot");
  if (!message.primitives.empty() || !message.meshes.empty())
    if (auto added = add(message, items); !added) return added;
  auto item = known(items, message.name);
  if (!item) return tl::unexpected(item.error());
  const auto root_T_link = transforms_.root_T_frame(message.link, ros::Time());
  if (!root_T_link) return tl::unexpected(root_T_link.error());
  const auto root_T_frame = transforms_.root_T_frame((*item)->frame, ros::Time());
  if (!root_T_frame) return tl::unexpected(root_T_frame.error());
  (*item)->frame_T_object = root_T_link->inverse() * *root_T_frame * (*item)->frame_T_object;
  (*item)->frame = message.link;
  (*item)->held = true;
  (*item)->touch_links = message.touch_links;
  return {};
}

tl::expected<void, Status> PlanningScene::detach(const std::string& name, Items& items) const {
  auto item = known(items, name);
  if (!item) return tl::unexpected(item.error());
  if (!(*item)->held) return failure(ArmCode::kNothingHeld, "no gripper holds it");
  const auto root_T_link = transforms_.root_T_frame((*item)->frame, ros::Time());
  if (!root_T_link) return tl::unexpected(root_T_link.error());
  (*item)->held = false;
  (*item)->touch_links.clear();
  return place(*root_T_link * (*item)->frame_T_object, **item);
}

Result<void> PlanningScene::set_seen(std::optional<arm::WorldObject> object, bool noticeable) {
  arm::CollisionWorld seen;
  if (object) {
    object->name = kSeenName;
    if (auto added = seen.add(*object); !added) return added;
  }
  const std::lock_guard lock(mutex_);
  seen_ = std::move(seen);
  if (noticeable) ++version_;
  return {};
}

/// True when set_found() must not change it; under mutex_.
bool PlanningScene::stays(const CollisionObject& item) const {
  return item.held || !item.found || holds_.count(item.name) > 0 || holds_.count(item.label) > 0;
}

tl::expected<bool, Status> PlanningScene::set_found(const std::vector<CollisionObject>& found) {
  const std::lock_guard lock(mutex_);
  Items items = items_;
  bool changed = false;
  for (auto item = items.begin(); item != items.end();) {
    const bool listed = std::any_of(found.begin(), found.end(),
                                    [&](const CollisionObject& one) { return one.name == item->first; });
    changed = changed || (!listed && !stays(item->second));
    item = listed || stays(item->second) ? std::next(item) : items.erase(item);
  }
  for (const auto& one : found) {
    if (transforms_.is_link(one.name))
      return failure(ArmCode::kInvalidRequest, "a detected object has the name of the link " + one.name +
                                                   ": give the class another name");
    const auto previous = items.find(one.name);
    if (previous != items.end() && (stays(previous->second) || same(previous->second, one))) continue;
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

std::uint64_t PlanningScene::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

tl::expected<arm::CollisionWorld, Status> PlanningScene::world() const {
  const std::lock_guard lock(mutex_);
  return world_of(items_);
}

tl::expected<arm::CollisionWorld, Status> PlanningScene::world_of(const Items& items) const {
  arm::CollisionWorld world = seen_;
  std::map<std::string, Pose> frames;
  for (const auto& [name, item] : items) {
    Result<void> done;
    if (item.held) {
      done = world.attach({name, item.frame, item.shapes, item.frame_T_object, item.touch_links});
    } else {
      auto frame = frames.find(item.frame);
      if (frame == frames.end()) {
        const auto pose = transforms_.root_T_frame(item.frame, ros::Time());
        if (!pose) return tl::unexpected(pose.error());
        frame = frames.emplace(item.frame, *pose).first;
      }
      done = world.add({name, item.shapes, frame->second * item.frame_T_object});
    }
    if (!done) return failure(ArmCode::kInvalidRequest, done.error().message);
  }
  return world;
}

tl::expected<std::vector<CollisionObject>, Status> PlanningScene::find(
    const std::string& name_or_label) const {
  const std::lock_guard lock(mutex_);
  std::vector<CollisionObject> found;
  for (const auto& [name, item] : items_)
    if (name == name_or_label) found = {item};
  if (found.empty())
    for (const auto& [name, item] : items_)
      if (item.label == name_or_label) found.push_back(item);
  if (found.empty())
    return failure(ArmCode::kUnknownObject,
                   "no object in the scene has the name or the label '" + name_or_label + "'");
  for (auto& item : found) {
    const auto root_T_frame = transforms_.root_T_frame(item.frame, ros::Time());
    if (!root_T_frame) return tl::unexpected(root_T_frame.error());
    item.frame_T_object = *root_T_frame * item.frame_T_object;
  }
  return found;
}

std::optional<CollisionObject> PlanningScene::held_by(const std::string& link) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, item] : items_)
    if (item.held && item.frame == link) return item;
  return std::nullopt;
}

tl::expected<std::vector<SceneObject>, Status> PlanningScene::messages() const {
  const std::lock_guard lock(mutex_);
  std::vector<SceneObject> messages;
  for (const auto& [name, item] : items_) {
    SceneObject message;
    message.operation = item.held ? SceneObject::ATTACH : SceneObject::ADD;
    message.name = name;
    message.label = item.label;
    message.pose.header.frame_id = item.frame;
    message.pose.pose = ros_convert::to_message(item.frame_T_object);
    if (item.held) message.link = item.frame;
    message.touch_links = item.touch_links;
    ros_convert::fill_shapes(item.shapes, message);
    messages.push_back(std::move(message));
  }
  return messages;
}

visualization_msgs::MarkerArray PlanningScene::markers(const std::string& root_link) const {
  const std::lock_guard lock(mutex_);
  visualization_msgs::MarkerArray array;
  visualization_msgs::Marker clear;
  clear.action = visualization_msgs::Marker::DELETEALL;
  array.markers.push_back(clear);
  for (const auto& [name, item] : items_) {
    int id = 0;
    for (const auto& shape : item.shapes) {
      auto marker = ros_convert::to_marker(shape.geometry);
      marker.ns = name;
      marker.id = id++;
      marker.header.frame_id = item.frame.empty() ? root_link : item.frame;
      marker.frame_locked = true;
      marker.pose = ros_convert::to_message(item.frame_T_object * shape.body_T_shape);
      if (item.held)
        set_color(marker, 0.75F, 0.45F, 0.75F);
      else
        set_color(marker, 0.30F, 0.60F, 0.35F);
      array.markers.push_back(marker);
    }
  }
  for (const auto& [name, seen] : seen_.objects())
    for (const auto& shape : seen->object.shapes) {
      auto marker = ros_convert::to_marker(shape.geometry);
      marker.ns = name;
      marker.id = static_cast<int>(array.markers.size());
      marker.header.frame_id = root_link;
      marker.frame_locked = true;
      marker.pose = ros_convert::to_message(seen->object.root_T_object * shape.body_T_shape);
      set_color(marker, 0.90F, 0.55F, 0.15F);
      array.markers.push_back(std::move(marker));
    }
  return array;
}

}  // namespace extperfc::ros_arm
