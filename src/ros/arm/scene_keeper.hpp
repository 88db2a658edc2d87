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

#include "ros/arm/ending.hpp"
#include "ros/arm/frame_finder.hpp"

namespace extperfc::arm_node {

/// A thing of the scene.
struct SceneItem {
  std::string name;
  std::string label;
  std::vector<Shape> shapes;
  std::string frame;  ///< that it stands still in, or the link that carries it
  Pose frame_T_object{Pose::Identity()};
  bool held{false};
  std::vector<std::string> touch_links;  ///< of a held one
  bool found{false};                     ///< it came from set_found(), and nobody has replaced it
  bool still{false};                     ///< of items(): set_found() leaves it alone
};

/// What arms must not touch, and what hands hold. Things that were given in a frame that is no link of the
/// robot, or in the root's, stand still in `world_frame` (or their own frame) while the base drives.
/// Thread-safe.
class SceneKeeper {
 public:
  /// The reference is kept.
  SceneKeeper(const FrameFinder& frames, std::string world_frame)
      : frames_(frames), world_frame_(std::move(world_frame)) {}

  /// All of them or, with an ending that names the object, none. At most kMostObjects things.
  [[nodiscard]] tl::expected<void, Ending> apply(const std::vector<extperfc::SceneObject>& objects);

  /// What a depth camera sees, in the frame of the robot's root: until the next call it is in world() under
  /// kSeenName, and nowhere else but in markers(). It goes, as all things do, when apply() removes
  /// everything. The version grows only with a `noticeable` change. Errors: an object that CollisionWorld
  /// refuses.
  [[nodiscard]] Result<void> set_seen(std::optional<arm::WorldObject> object, bool noticeable);

  /// What detections found, each in a frame that it stands still in; what the call before brought and this
  /// one does not goes. Things of the same name that a hand holds, that hold() keeps, or that apply() put in
  /// stay as they are. True when something changed: then the version grew. Endings: a name that a link has,
  /// more than kMostObjects, what CollisionWorld refuses; nothing has changed then.
  [[nodiscard]] tl::expected<bool, Ending> set_found(const std::vector<SceneItem>& found);
  /// Until all copies of what it returns are gone, set_found() leaves things of this name or label alone.
  [[nodiscard]] std::shared_ptr<const void> hold(const std::string& name_or_label);
  /// As they are remembered: frame_T_object in their own frames.
  [[nodiscard]] std::vector<SceneItem> items() const;

  /// Grows with every change that a caller made.
  [[nodiscard]] std::uint64_t version() const;
  /// As it is now, in the frame of the robot's root. Ending: kUnknownFrame when tf lost a frame.
  [[nodiscard]] tl::expected<arm::CollisionWorld, Ending> world() const;
  /// Things with this name, or else all with this label; each with root_T_object in frame_T_object.
  [[nodiscard]] tl::expected<std::vector<SceneItem>, Ending> find(const std::string& name_or_label) const;
  /// What this link holds.
  [[nodiscard]] std::optional<SceneItem> held_by(const std::string& link) const;

  [[nodiscard]] tl::expected<std::vector<extperfc::SceneObject>, Ending> messages() const;
  [[nodiscard]] visualization_msgs::MarkerArray markers(const std::string& root_link) const;

  static constexpr std::size_t kMostObjects = 1000;
  static constexpr const char* kSeenName = "depth";  ///< no other thing may have it

 private:
  using Items = std::map<std::string, SceneItem>;

  [[nodiscard]] tl::expected<void, Ending> change(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Ending> add(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Ending> attach(const extperfc::SceneObject& message, Items& items) const;
  [[nodiscard]] tl::expected<void, Ending> detach(const std::string& name, Items& items) const;
  [[nodiscard]] tl::expected<void, Ending> place(const Pose& root_T_object, SceneItem& item) const;
  [[nodiscard]] tl::expected<arm::CollisionWorld, Ending> world_of(const Items& items) const;
  [[nodiscard]] bool stays(const SceneItem& item) const;

  const FrameFinder& frames_;
  const std::string world_frame_;
  mutable std::mutex mutex_;
  Items items_;
  arm::CollisionWorld seen_;          ///< nothing, or one object
  std::multiset<std::string> holds_;  ///< names and labels, see hold()
  std::uint64_t version_{0};
};

}  // namespace extperfc::arm_node
