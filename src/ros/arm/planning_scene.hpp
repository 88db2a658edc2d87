#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <extperfc/SceneObject.h>
#include <visualization_msgs/MarkerArray.h>

#include "extperfc/arm/collision_world.hpp"

#include "ros/arm/status.hpp"
#include "ros/arm/transform_lookup.hpp"

namespace extperfc::ros_arm {

/// An object of the planning scene.
struct CollisionObject {
  std::string name;
  std::string label;
  std::vector<Shape> shapes;
  std::string frame;  ///< in which it stands still, or the link that carries it
  Pose frame_T_object{Pose::Identity()};
  bool held{false};
  std::vector<std::string> touch_links;  ///< of a held one
  bool found{false};                     ///< it came from set_found() and was not replaced since
  bool still{false};                     ///< of items(): set_found() leaves it alone
};

/// Collision objects around the robot, and objects that grippers hold. Objects given in a frame that is not a
/// link of the robot, or in the root's frame, stand still in `world_frame` (or their own frame) while the
/// base drives. Thread-safe.
class PlanningScene {
 public:
  /// Keeps the reference.
  PlanningScene(const TransformLookup& transforms, std::string world_frame)
      : transforms_(transforms), world_frame_(std::move(world_frame)) {}

  /// Applies all changes or, on an error, none. Errors name the object. At most kMaxObjects objects.
  [[nodiscard]] tl::expected<void, Status> apply(const std::vector<extperfc::SceneObject>& objects);

  /// Sets what a depth camera sees, in the frame of the robot's root. Until the next call only world() (under
  /// kSeenName) and markers() contain it. Like all objects it is removed when apply() removes everything.
  /// Only a `noticeable` change increases the version. Errors: an object that CollisionWorld rejects.
  [[nodiscard]] Result<void> set_seen(std::optional<arm::WorldObject> object, bool noticeable);

  /// Replaces the detected objects, each in a frame in which it stands still. Objects of the same name that a
  /// gripper holds, that hold() protects or that apply() added stay unchanged. Returns true, and increases
  /// the version, when the scene changed. Errors, with the scene unchanged: the name of a link, more than
  /// kMaxObjects, an object that CollisionWorld rejects.
  [[nodiscard]] tl::expected<bool, Status> set_found(const std::vector<CollisionObject>& found);
  /// Until all copies of the returned pointer are destroyed, set_found() leaves objects of this name or label
  /// unchanged.
  [[nodiscard]] std::shared_ptr<const void> hold(const std::string& name_or_label);
  /// All objects, with frame_T_object in their own frames.
  [[nodiscard]] std::vector<CollisionObject> items() const;

  /// Increases with every change.
  [[nodiscard]] std::uint64_t version() const;
  /// The present world in the frame of the robot's root. Error: kUnknownFrame when tf lacks a frame.
  [[nodiscard]] tl::expected<arm::CollisionWorld, Status> world() const;
  /// The object with this name, or else all with this label; each with root_T_object in frame_T_object.
  [[nodiscard]] tl::expected<std::vector<CollisionObject>, Status> find(
      const std::string& name_or_label) const;
  /// The object that this link holds.
  [[nodiscard]] std::optional<CollisionObject> held_by(const std::string& link) const;

  [[nodiscard]] tl::expected<std::vector<extperfc::SceneObject>, Status> messages() const;
  [[nodiscard]] visualization_msgs::MarkerArray markers(const std::string& root_link) const;

  static constexpr std::size_t kMaxObjects = 1000;
  static constexpr const char* kSeenName = "depth";  ///< reserved

 private:
  using Items = std::map<std::string, CollisionObject>;

  [[nodiscard]] tl::expected<void, Status> change(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Status> add(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Status> attach(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Status> detach(const std::string& name, Items& items) const;
  [[nodiscard]] tl::expected<void, Status> place(const Pose& root_T_object, CollisionObject& item) const;
  [[nodiscard]] tl::expected<arm::CollisionWorld, Status> world_of(const Items& items) const;
  [[nodiscard]] bool stays(const CollisionObject& item) const;

  const TransformLookup& transforms_;
  const std::string world_frame_;
  mutable std::mutex mutex_;
  Items items_;
  arm::CollisionWorld seen_;          ///< empty, or one object
  std::multiset<std::string> holds_;  ///< names and labels, see hold()
  std::uint64_t version_{0};
};

}  // namespace extperfc::ros_arm
