#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/arm/collision_model.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/shape.hpp"

namespace extperfc::arm {

struct ConvexPart;
using Parts = std::vector<std::shared_ptr<const ConvexPart>>;

/// An object of the world. Meshes are treated as their convex hulls.
struct WorldObject {
  std::string name;                      ///< unique, not empty, not the name of a link
  std::vector<Shape> shapes;             ///< body_T_shape is in the object's frame
  Pose root_T_object{Pose::Identity()};  ///< in the frame of the robot's root link
};

/// An object attached to a link, for example held by a gripper.
struct AttachedObject {
  std::string name;           ///< unique among all objects
  std::string link;           ///< that carries it
  std::vector<Shape> shapes;  ///< body_T_shape is in the object's frame
  Pose link_T_object{Pose::Identity()};
  std::vector<std::string> touch_links;  ///< links it may touch beside `link`, e.g. the fingers
};

/// Objects around the robot and objects that it carries. A value: a copy shares the shapes and costs one map
/// of pointers. Not thread-safe for writing.
class CollisionWorld {
 public:
  /// Adds an object or replaces the one of that name. Errors: no name, no shapes, a size that is not
  /// positive, a pose that is not finite, a mesh that cannot be read; the world is then unchanged. O(corners)
  /// for meshes.
  [[nodiscard]] Result<void> add(const WorldObject& object);
  [[nodiscard]] Result<void> attach(const AttachedObject& object);
  /// Errors: no world object of that name.
  [[nodiscard]] Result<void> move(const std::string& name, const Pose& root_T_object);
  /// Of either kind; false when there is none.
  bool remove(const std::string& name);
  void clear();

  /// Contact of an object with a link or with an attached object is no collision from now on.
  void allow(const std::string& a, const std::string& b) { allowed_.allow(a, b); }

  struct Placed {
    WorldObject object;
    Parts parts;
  };
  struct Carried {
    AttachedObject object;
    Parts parts;
  };
  [[nodiscard]] const std::map<std::string, std::shared_ptr<const Placed>>& objects() const {
    return objects_;
  }
  [[nodiscard]] const std::map<std::string, std::shared_ptr<const Carried>>& attached() const {
    return attached_;
  }
  [[nodiscard]] const AllowedPairs& allowed() const { return allowed_; }

 private:
  std::map<std::string, std::shared_ptr<const Placed>> objects_;
  std::map<std::string, std::shared_ptr<const Carried>> attached_;
  AllowedPairs allowed_;
};

}  // namespace extperfc::arm
