#include "arm/collision/exact_pairs.hpp"

#include <algorithm>
#include <utility>

#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

namespace extperfc::arm {
namespace {

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

btTransform to_bullet(const Pose& pose) {
  const auto& r = pose.linear();
  return btTransform(
      btMatrix3x3(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)),
      to_bullet(Eigen::Vector3d(pose.translation())));
}

/// Without margins: boxes and cylinders with sharp edges, cones and hulls not grown. (A sphere's margin is
/// its radius.)
std::unique_ptr<btConvexShape> bullet_shape(const ConvexPart& part) {
  const Eigen::Vector3d& half = part.half;
  std::unique_ptr<btConvexShape> shape;
  switch (part.kind) {
    case PartKind::kBox:
      shape = std::make_unique<btBoxShape>(to_bullet(half));
      break;
    case PartKind::kCylinder:
      shape = std::make_unique<btCylinderShapeZ>(to_bullet(half));
      break;
    case PartKind::kSphere:
      return std::make_unique<btSphereShape>(half.x());
    case PartKind::kCone:
      shape = std::make_unique<btConeShapeZ>(half.x(), 2 * half.z());
      break;
    case PartKind::kHull: {
      auto hull = std::make_unique<btConvexHullShape>();
      for (const auto& vertex : part.vertices) hull->addPoint(to_bullet(vertex), false);
      hull->recalcLocalAabb();
      shape = std::move(hull);
      break;
    }
  }
  shape->setMargin(0);
  return shape;
}

Eigen::Vector3d support_point(const ConvexPart& part, const Pose& pose, const Eigen::Vector3d& direction) {
  return pose * support(part, pose.linear().transpose() * direction);
}

double support_value(const ConvexPart& part, const Pose& pose, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d local = pose.linear().transpose() * direction;
  return direction.dot(pose.translation()) + local.dot(support(part, local));
}

}  // namespace

struct ExactPairs::Bullet {
  std::vector<std::unique_ptr<btConvexShape>> moving, obstacles;
  std::vector<btTransform> obstacle_poses;
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;

  /// How deep two shapes that touch are in each other, as EPA sees it [m].
  double penetration_m(const btConvexShape& a, const btTransform& a_pose, const btConvexShape& b,
                       const btTransform& b_pose) {
    btGjkPairDetector detector(&a, &b, &simplex, &depth);
    btGjkPairDetector::ClosestPointInput input;
    input.m_transformA = a_pose;
    input.m_transformB = b_pose;
    input.m_maximumDistanceSquared = BT_LARGE_FLOAT;
    btPointCollector collector;
    detector.getClosestPoints(input, collector, nullptr);
    return collector.m_hasResult ? std::max(0.0, -collector.m_distance) : 0.0;
  }
};

void BodyPlacement::set(const Scene& scene, const std::vector<Pose>& root_T_body) {
  scene_ = &scene;
  root_T_body_ = root_T_body;
  parts_.resize(scene.moving.size());
  known_.assign(scene.moving.size(), 0);
}

void BodyPlacement::set(const Bodies& bodies, const Scene& scene, const double* positions) {
  scene_ = &scene;
  body_poses(bodies, positions, root_T_body_);
  parts_.resize(scene.moving.size());
  known_.assign(scene.moving.size(), 0);
}

const BodyPlacement::Part& BodyPlacement::part(int index) const {
  Part& own = parts_[index];
  if (known_[index] != 0) return own;
  const MovingPart& part = scene_->moving[index];
  const Pose& body = root_T_body_[part.body];
  own.root_T_part.linear().noalias() = body.linear() * part.body_T_part.linear();
  own.root_T_part.translation() = body.translation() + body.linear() * part.body_T_part.translation();
  own.root_T_part.makeAffine();
  own.half = rotated_half(*part.part, own.root_T_part.linear());
  known_[index] = 1;
  return own;
}

void set_velocities(const Bodies& bodies, const std::vector<double>& rates, Moment& moment) {
  moment.angular_velocity.assign(bodies.bodies.size(), Eigen::Vector3d::Zero());
  moment.sliding.assign(bodies.bodies.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 1; i < bodies.bodies.size(); ++i) {
    const Body& body = bodies.bodies[i];
    const Eigen::Vector3d axis = rates[i] * moment.placement.bodies()[i].linear().col(2);
    moment.angular_velocity[i] = moment.angular_velocity[body.parent];
    moment.sliding[i] = moment.sliding[body.parent];
    if (body.prismatic) {
      moment.sliding[i] += axis;
    } else {
      moment.angular_velocity[i] += axis;
      moment.sliding[i] += moment.placement.bodies()[i].translation().cross(axis);
    }
  }
}

ExactPairs::ExactPairs(const Scene& scene) : scene_(scene), bullet_(std::make_unique<Bullet>()) {
  for (const auto& part : scene.moving) bullet_->moving.push_back(bullet_shape(*part.part));
  for (const auto& obstacle : scene.obstacles) {
    bullet_->obstacles.push_back(bullet_shape(*obstacle.part));
    obstacle_half_.push_back(rotated_half(*obstacle.part, obstacle.root_T_part.linear()));
    bullet_->obstacle_poses.push_back(to_bullet(obstacle.root_T_part));
  }
  axes_.assign(scene.pairs.size(), Eigen::Vector3d::Zero());
}

ExactPairs::~ExactPairs() = default;

double ExactPairs::lowest(int part, const BodyPlacement& placement, const Eigen::Vector3d& m) const {
  return -support_value(*scene_.moving[part].part, placement.part(part).root_T_part, -m);
}

double ExactPairs::highest(const PartPair& pair, const BodyPlacement& placement,
                           const Eigen::Vector3d& m) const {
  if (pair.self) {
    return support_value(*scene_.moving[pair.other].part, placement.part(pair.other).root_T_part, m);
  }
  const Obstacle& obstacle = scene_.obstacles[pair.other];
  return support_value(*obstacle.part, obstacle.root_T_part, m);
}

Separation ExactPairs::along(const PartPair& pair, const BodyPlacement& placement,
                             const Eigen::Vector3d& normal) const {
  return {normal, lowest(pair.part, placement, normal) - highest(pair, placement, normal)};
}

std::optional<Separation> ExactPairs::remembered(int index, const BodyPlacement& placement) const {
  if (axes_[index].isZero()) return std::nullopt;
  const PartPair& pair = scene_.pairs[index];
  return along(pair, placement, placement.bodies()[pair.ancestor].linear() * axes_[index]);
}

Proximity ExactPairs::proximity(const PartPair& pair, const BodyPlacement& placement,
                                double relative_tolerance) {
  ++queries_;
  const ConvexPart& part = *scene_.moving[pair.part].part;
  const Pose& part_pose = placement.part(pair.part).root_T_part;
  const ConvexPart& other = pair.self ? *scene_.moving[pair.other].part : *scene_.obstacles[pair.other].part;
  const Pose& other_pose =
      pair.self ? placement.part(pair.other).root_T_part : scene_.obstacles[pair.other].root_T_part;
  const Eigen::Vector3d apart = part_pose.translation() - other_pose.translation();
  const auto lowest = [&](const Eigen::Vector3d& direction) {
    return Eigen::Vector3d(support_point(part, part_pose, -direction) -
                           support_point(other, other_pose, direction));
  };
  return gjk(lowest, apart.isZero() ? Eigen::Vector3d::UnitZ() : apart, relative_tolerance);
}

Separation ExactPairs::separation(int index, const BodyPlacement& placement) {
  constexpr double kLoose = 0.01;  // of the gap: an axis need not be better
  const PartPair& pair = scene_.pairs[index];
  const Proximity found = proximity(pair, placement, kLoose);
  if (!(found.at_least_m > 0)) return {found.axis, std::min(found.at_least_m, 0.0)};
  axes_[index] = placement.bodies()[pair.ancestor].linear().transpose() * found.axis;
  return along(pair, placement, found.axis);
}

double ExactPairs::signed_distance(int index, const BodyPlacement& placement) {
  const PartPair& pair = scene_.pairs[index];
  const Proximity found = proximity(pair, placement, 0);
  if (found.at_least_m > 0) return found.at_least_m;
  const btConvexShape& other = pair.self ? *bullet_->moving[pair.other] : *bullet_->obstacles[pair.other];
  const btTransform other_pose =
      pair.self ? to_bullet(placement.part(pair.other).root_T_part) : bullet_->obstacle_poses[pair.other];
  return -bullet_->penetration_m(*bullet_->moving[pair.part],
                                 to_bullet(placement.part(pair.part).root_T_part), other, other_pose);
}

double ExactPairs::rough_bound(int index, const BodyPlacement& placement) const {
  const PartPair& pair = scene_.pairs[index];
  const BodyPlacement::Part& part = placement.part(pair.part);
  if (pair.self) {
    const BodyPlacement::Part& other = placement.part(pair.other);
    return ((part.root_T_part.translation() - other.root_T_part.translation()).cwiseAbs() - part.half -
            other.half)
        .maxCoeff();
  }
  const Eigen::Vector3d apart =
      part.root_T_part.translation() - scene_.obstacles[pair.other].root_T_part.translation();
  return (apart.cwiseAbs() - part.half - obstacle_half_[pair.other]).maxCoeff();
}

// With the plane's normal n fixed in the ancestor's frame, a point x of a body with velocity v + w x x there
// has n . x(t) = n . x + t n . v + t (n x w) . x up to the bend: the smallest over the body is a support
// function, and as a smallest value of functions linear in t it is smallest at an end of the interval.
bool ExactPairs::stays_apart(int index, const Moment& moment, const Separation& separation, double half,
                             double bend_m) const {
  const PartPair& pair = scene_.pairs[index];
  const MovingPart& part = scene_.moving[pair.part];
  const Eigen::Vector3d& n = separation.normal;
  const auto angular_velocity = [&](int body) {
    return Eigen::Vector3d(moment.angular_velocity[body] - moment.angular_velocity[pair.ancestor]);
  };
  const auto sliding = [&](int body) { return n.dot(moment.sliding[body] - moment.sliding[pair.ancestor]); };
  for (const double t : {-half, half}) {
    const double low = t * sliding(part.body) +
                       lowest(pair.part, moment.placement, n + t * n.cross(angular_velocity(part.body)));
    double high = 0;
    if (pair.self) {
      const int other = scene_.moving[pair.other].body;
      high = t * sliding(other) + highest(pair, moment.placement, n + t * n.cross(angular_velocity(other)));
    } else {
      high = highest(pair, moment.placement, n);
    }
    if (!(low - high - bend_m > pair.padding_m + kMinGap_m)) return false;
  }
  return true;
}

}  // namespace extperfc::arm
