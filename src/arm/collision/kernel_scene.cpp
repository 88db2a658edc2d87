#include "arm/collision/kernel_scene.hpp"

#include <algorithm>
#include <cmath>
#include <new>

namespace extperfc::arm {
namespace {

/// Rounding of the kernel: a position after a chain of 16 joints at up to 4 m from the root is off by less
/// than 1e-5 m in single precision (measured: 2e-6); two of them, and as much again.
constexpr double kRounding = 2e-5;          // [m]
constexpr double kRoundingPerMetre = 1e-6;  // of the coordinates of an obstacle, or of a reach beyond

/// Not below `value`.
float up(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest < value ? std::nextafterf(nearest, INFINITY) : nearest;
}

template <typename Matrix>
void store_rows(const Matrix& rotation, float* out) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      out[3 * row + column] = static_cast<float>(rotation(row, column));
}

void store(const Eigen::Vector3d& point, float* out) {
  for (int axis = 0; axis < 3; ++axis) out[axis] = static_cast<float>(point[axis]);
}

KernelShape kernel_shape(PartKind kind) {
  switch (kind) {
    case PartKind::kBox:
      return KernelShape::kBox;
    case PartKind::kSphere:
      return KernelShape::kSphere;
    case PartKind::kCylinder:
      return KernelShape::kCylinder;
    case PartKind::kCone:
      return KernelShape::kCone;
    case PartKind::kHull:
      break;
  }
  return KernelShape::kPlanes;
}

double extra_for(const Obstacle& obstacle, const MovingPart& part) {
  const double size = obstacle.root_T_part.translation().norm() + obstacle.part->half.norm();
  return kRounding +
         kRoundingPerMetre * (size + part.reach.in_root.centre.norm() + part.reach.in_root.radius);
}

double extra_for(const MovingPart& a, const MovingPart& b) {
  return kRounding + kRoundingPerMetre * (a.reach.in_root.centre.norm() + a.reach.in_root.radius +
                                          b.reach.in_root.centre.norm() + b.reach.in_root.radius);
}

}  // namespace

KernelTables::KernelTables(const Bodies& bodies, const Scene& scene) {
  add_bodies(bodies, scene);
  add_parts(scene);
  add_obstacles(scene);
  add_pairs(scene);
}

void KernelTables::add_bodies(const Bodies& bodies, const Scene& scene) {
  for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
    const Body& body = bodies.bodies[i];
    KernelBody own{};
    own.parent = body.parent;
    own.joint = body.joint;
    own.multiplier = static_cast<float>(body.multiplier);
    own.offset = static_cast<float>(body.offset);
    own.prismatic = body.prismatic;
    store_rows(body.parent_T_joint.linear(), own.rotation);
    store(body.parent_T_joint.translation(), own.translation);
    const Ball ball = body_ball(scene, static_cast<int>(i));
    store(ball.centre, own.ball);
    own.ball_radius = up(ball.radius);
    bodies_.push_back(own);
  }
}

void KernelTables::add_parts(const Scene& scene) {
  for (const MovingPart& part : scene.moving) {
    KernelPart own{};
    own.body = part.body;
    store(part.ball.centre, own.ball.centre);
    own.ball.radius = up(part.ball.radius);
    own.first_sphere = static_cast<int>(spheres_.size());
    for (const Ball& ball : part.cover) {
      KernelSphere sphere{};
      store(ball.centre, sphere.centre);
      sphere.radius = up(ball.radius);
      spheres_.push_back(sphere);
    }
    own.sphere_end = static_cast<int>(spheres_.size());
    parts_.push_back(own);
  }
}

void KernelTables::add_obstacles(const Scene& scene) {
  for (const Obstacle& obstacle : scene.obstacles) {
    KernelObstacle own{};
    own.shape = kernel_shape(obstacle.part->kind);
    const Eigen::Matrix3d rotation = obstacle.root_T_part.linear();
    own.upright = own.shape == KernelShape::kSphere || rotation == Eigen::Matrix3d::Identity();
    store(obstacle.root_T_part.translation(), own.centre);
    store_rows(rotation, own.rotation);
    for (int axis = 0; axis < 3; ++axis) own.half[axis] = up(obstacle.part->half[axis]);
    const Eigen::Vector3d half = rotated_half(*obstacle.part, rotation);
    for (int axis = 0; axis < 3; ++axis) {
      own.low[axis] = -up(half[axis] - obstacle.root_T_part.translation()[axis]);
      own.high[axis] = up(half[axis] + obstacle.root_T_part.translation()[axis]);
    }
    own.first_plane = static_cast<int>(planes_.size());
    for (const Plane& plane : obstacle.part->planes) {
      const Eigen::Vector3d normal = rotation * plane.normal;
      KernelPlane rotated{};
      store(normal, rotated.normal);
      rotated.offset = up(plane.offset + normal.dot(obstacle.root_T_part.translation()));
      planes_.push_back(rotated);
    }
    own.plane_end = static_cast<int>(planes_.size());
    obstacles_.push_back(own);
  }
}

void KernelTables::add_pairs(const Scene& scene) {
  for (const PairGroup& group : scene.groups) {
    KernelGroup own{group.body, group.other, 0, group.first_pair, group.pair_end};
    for (int i = group.first_pair; i < group.pair_end; ++i) {
      const PartPair& pair = scene.pairs[i];
      const MovingPart& part = scene.moving[pair.part];
      const double extra = pair.self ? extra_for(part, scene.moving[pair.other])
                                     : extra_for(scene.obstacles[pair.other], part);
      pairs_.push_back({pair.part, pair.other, up(pair.padding_m + extra)});
      own.padding = std::max(own.padding, pairs_.back().padding);
    }
    (group.self ? self_groups_ : world_groups_).push_back(own);
  }
}

KernelScene KernelTables::view() const {
  const auto count = [](const auto& items) { return static_cast<int>(items.size()); };
  return {bodies_.data(),       count(bodies_),      parts_.data(),      count(parts_), spheres_.data(),
          count(spheres_),      obstacles_.data(),   planes_.data(),     pairs_.data(), world_groups_.data(),
          count(world_groups_), self_groups_.data(), count(self_groups_)};
}

namespace {
constexpr std::align_val_t kAlignment{4 * kLanes};
}

void KernelMemory::Release::operator()(float* memory) const {
  ::operator delete[](memory, kAlignment);
}

KernelMemory::KernelMemory(const KernelScene& scene)
    : bytes_(2 * static_cast<std::size_t>(scene.part_count)) {
  const auto max_flags = [](const KernelGroup* groups, int count) {
    int largest = 0;
    for (int i = 0; i < count; ++i) largest = std::max(largest, groups[i].pair_end);
    return largest;
  };
  flags_.resize(std::max(max_flags(scene.world_groups, scene.world_group_count),
                         max_flags(scene.self_groups, scene.self_group_count)));
  const std::size_t inputs = static_cast<std::size_t>(kMaxJoints) * kLanes;
  const std::size_t floats = inputs + kernel_floats(scene);
  floats_.reset(static_cast<float*>(::operator new[](floats * sizeof(float), kAlignment)));
  std::fill_n(floats_.get(), floats, 0.0F);
  positions_ = floats_.get();
  scratch_ = {floats_.get() + inputs, bytes_.data(), flags_.data()};
}

}  // namespace extperfc::arm
