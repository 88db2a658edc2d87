#pragma once

#include <memory>
#include <string>
#include <vector>

#include <btBulletCollisionCommon.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/shape.hpp"

#include "simulate/bodies/mass_properties.hpp"

namespace extperfc::simulate {

/// A collision shape together with the parts that it refers to.
class CollisionShape {
 public:
  /// Shapes of one body, moved by `frame_T_body` into the frame that Bullet shall move. Meshes count as their
  /// convex hulls. Error: names `owner` and the size that Bullet cannot take.
  [[nodiscard]] static Result<CollisionShape> make(const std::string& owner, const std::vector<Shape>& shapes,
                                                   const Pose& frame_T_body);
  /// A ball without contacts, for what has a place but no shape.
  [[nodiscard]] static CollisionShape placeholder();
  /// Upright capsule around z from 0 to `height_m`.
  [[nodiscard]] static CollisionShape capsule(double radius_m, double height_m);

  [[nodiscard]] btCollisionShape* get() const { return root_; }

 private:
  btCollisionShape* add(std::unique_ptr<btCollisionShape> part);

  std::vector<std::unique_ptr<btCollisionShape>> parts_;
  btCollisionShape* root_{nullptr};
};

/// Mass properties of solid shapes of one density that weigh `mass_kg` together, in the body's frame. A mesh
/// counts as the box around it. Shapes as CollisionShape::make accepts them.
[[nodiscard]] MassProperties solid_mass_properties(const std::vector<Shape>& shapes, double mass_kg);

/// Shortest length through a shape [m]: what a step must not jump over.
[[nodiscard]] double thickness(const std::vector<Shape>& shapes);

}  // namespace extperfc::simulate
