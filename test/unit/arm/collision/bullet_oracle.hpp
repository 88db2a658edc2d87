#pragma once

#include <memory>
#include <string>
#include <vector>

#include <btBulletCollisionCommon.h>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/srdf.hpp"
#include "extperfc/world/robot_model.hpp"
#include "extperfc/world/stl.hpp"

namespace extperfc::arm::test {

/// A judge that shares nothing with the checker but the description of robot and world: link poses from
/// RobotModel, contacts from Bullet's own dispatcher (box against box by separating axes, the rest by GJK
/// with Bullet's margins, which only make shapes smaller), every pair, one after the other.
class BulletOracle {
 public:
  BulletOracle(const RobotModel& robot, const CollisionModelParams& params, const CollisionWorld& world)
      : robot_(robot),
        params_(params),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &configuration_) {
    for (std::size_t i = 0; i < robot.links().size(); ++i)
      for (const Shape& shape : robot.links()[i].collisions)
        add(robot.links()[i].name, static_cast<int>(i), shape.body_T_shape, shape,
            body_of(static_cast<int>(i)));
    for (const auto& [name, carried] : world.attached()) {
      const int link = robot.link(carried->object.link).value();
      allowed_.allow(name, carried->object.link);
      for (const auto& touched : carried->object.touch_links) allowed_.allow(name, touched);
      for (const Shape& shape : carried->object.shapes)
        add(name, link, carried->object.link_T_object * shape.body_T_shape, shape, body_of(link));
    }
    for (const auto& [name, placed] : world.objects())
      for (const Shape& shape : placed->object.shapes)
        add(name, -1, placed->object.root_T_object * shape.body_T_shape, shape, 0);
    allowed_.allow(params.allowed);
    allowed_.allow(world.allowed());
  }

  [[nodiscard]] bool collides(const JointVector& positions) {
    place(positions);
    for (std::size_t a = 0; a < entries_.size(); ++a)
      for (std::size_t b = a + 1; b < entries_.size(); ++b)
        if (entries_[a].body != entries_[b].body && boxes_meet(a, b) &&
            !allowed_.allows(entries_[a].name, entries_[b].name) && touch(a, b))
          return true;
    return false;
  }

 private:
  struct Entry {
    std::string name;
    int link;  // -1: of the world
    int body;
    Pose link_T_shape;
    std::unique_ptr<btConvexShape> shape;
    std::unique_ptr<btCollisionObject> object;
    btVector3 low, high;
  };
  struct Hit : btCollisionWorld::ContactResultCallback {
    bool hit{false};
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
      hit = hit || point.getDistance() < 0;
      return 0;
    }
  };

  static btVector3 bullet(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

  static std::unique_ptr<btConvexShape> bullet_shape(const Shape& shape) {
    constexpr double kMargin = 1e-4;
    if (const auto* box = std::get_if<Box>(&shape.geometry)) {
      auto made = std::make_unique<btBoxShape>(bullet(box->size_m / 2));
      made->setMargin(kMargin);
      return made;
    }
    if (const auto* c = std::get_if<Cylinder>(&shape.geometry)) {
      auto made = std::make_unique<btCylinderShapeZ>(btVector3(c->radius_m, c->radius_m, c->length_m / 2));
      made->setMargin(kMargin);
      return made;
    }
    if (const auto* sphere = std::get_if<Sphere>(&shape.geometry))
      return std::make_unique<btSphereShape>(sphere->radius_m);
    if (const auto* cone = std::get_if<Cone>(&shape.geometry)) {
      auto made = std::make_unique<btConeShapeZ>(cone->radius_m, cone->height_m);
      made->setMargin(0);
      return made;
    }
    const auto& mesh = std::get<TriangleMesh>(shape.geometry);
    auto made = std::make_unique<btConvexHullShape>();
    const auto triangles = read_stl_triangles(mesh.path).value();
    for (const auto& triangle : triangles)
      for (const auto& corner : triangle)
        made->addPoint(bullet(corner.cast<double>().cwiseProduct(mesh.scale)), false);
    made->recalcLocalAabb();
    made->setMargin(0);
    return made;
  }

  /// Links without a joint of the group between them have the same number.
  [[nodiscard]] int body_of(int link) const {
    while (robot_.links()[link].parent_joint >= 0) {
      const Joint& joint = robot_.joints()[robot_.links()[link].parent_joint];
      for (const auto& name : params_.joints)
        if (name == joint.name) return link;
      link = joint.parent_link;
    }
    return 0;
  }

  void add(const std::string& name, int link, const Pose& pose, const Shape& shape, int body) {
    Entry entry{name, link, body, pose, bullet_shape(shape), std::make_unique<btCollisionObject>(), {}, {}};
    entry.object->setCollisionShape(entry.shape.get());
    entries_.push_back(std::move(entry));
  }

  void place(const JointVector& positions) {
    std::vector<double> values(robot_.joints().size(), 0.0);
    for (const auto& [joint, value] : params_.fixed_positions) values[robot_.joint(joint).value()] = value;
    for (std::size_t i = 0; i < params_.joints.size(); ++i)
      values[robot_.joint(params_.joints[i]).value()] = positions[static_cast<Eigen::Index>(i)];
    const std::vector<Pose> links = robot_.link_poses(values);
    for (Entry& entry : entries_) {
      const Pose pose = entry.link < 0 ? entry.link_T_shape : links[entry.link] * entry.link_T_shape;
      const auto& r = pose.linear();
      const btTransform transform(
          btMatrix3x3(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
          bullet(pose.translation()));
      entry.object->setWorldTransform(transform);
      entry.shape->getAabb(transform, entry.low, entry.high);
    }
  }

  [[nodiscard]] bool boxes_meet(std::size_t a, std::size_t b) const {
    const Entry &first = entries_[a], &second = entries_[b];
    for (int axis = 0; axis < 3; ++axis)
      if (first.low[axis] > second.high[axis] || second.low[axis] > first.high[axis]) return false;
    return true;
  }

  bool touch(std::size_t a, std::size_t b) {
    Hit hit;
    world_.contactPairTest(entries_[a].object.get(), entries_[b].object.get(), hit);
    return hit.hit;
  }

  const RobotModel& robot_;
  const CollisionModelParams params_;
  AllowedPairs allowed_;
  std::vector<Entry> entries_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
};

}  // namespace extperfc::arm::test
