#include "simulate/bodies/scenery.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "simulate/bodies/bullet_conversions.hpp"

namespace extperfc::simulate {
namespace {

constexpr double kPersonRadius = 0.22;  // [m]
constexpr double kPersonHeight = 1.75;  // [m]

bool is_coefficient(double value) {
  return std::isfinite(value) && value >= 0;
}

Result<void> check(const BodySpec& spec) {
  const std::string who = "body \"" + spec.name + "\"";
  if (!spec.world_T_body.matrix().allFinite())
    return fail(ErrorCode::kInvalidArgument, who + ": its pose is not finite: check its numbers");
  if (!is_coefficient(spec.friction) || !is_coefficient(spec.restitution) || spec.restitution > 1 ||
      !is_coefficient(spec.rolling_friction))
    return fail(ErrorCode::kInvalidArgument,
                who + ": friction and rolling_friction must be 0 or more, restitution from 0 to 1");
  if (spec.mobility != Mobility::kLoose) return {};
  if (!(spec.mass_kg > 0) || !std::isfinite(spec.mass_kg))
    return fail(ErrorCode::kInvalidArgument, who + " is loose and has no mass: give it mass_kg above 0");
  if (spec.shapes.empty())
    return fail(ErrorCode::kInvalidArgument, who + " is loose and has no shape: give it one");
  return {};
}

/// A loose body's surface and sleep. Objects of some centimetres: Bullet's own thresholds let a ball that
/// rolls at 0.3 m/s fall asleep.
void set_loose(btRigidBody& body, double thickness_m) {
  body.setDamping(0.0, 0.02);
  body.setSleepingThresholds(0.01, 0.1);
  body.setCcdMotionThreshold(0.3 * thickness_m);
  body.setCcdSweptSphereRadius(0.45 * thickness_m);
}

}  // namespace

Result<std::unique_ptr<Scenery>> Scenery::make(PhysicsWorld& world, const WorldSpec& spec) {
  std::unique_ptr<Scenery> scenery(new Scenery(world));
  scenery->objects_.reserve(spec.bodies.size());
  for (const BodySpec& body : spec.bodies)
    if (auto added = scenery->add(body); !added) return tl::unexpected<Error>(added.error());
  for (const PersonSpec& person : spec.people) {
    Pose start = Pose::Identity();
    if (!person.path_m.empty()) start.translation() << person.path_m.front(), 0;
    if (!start.matrix().allFinite())
      return fail(ErrorCode::kInvalidArgument,
                  "person \"" + person.name + "\": the path is not finite: check its numbers");
    scenery->people_.push_back(std::make_unique<KinematicBody>(
        world, CollisionShape::capsule(kPersonRadius, kPersonHeight), start, ObjectKind::kPerson,
        scenery->people(), kPersonGroup, kLooseGroup | kLinkGroup));
    scenery->person_goals_.push_back(start);
  }
  return scenery;
}

Scenery::~Scenery() {
  for (Object& object : objects_) world_->bullet().removeRigidBody(object.body.get());
}

Result<void> Scenery::add(const BodySpec& spec) {
  if (auto checked = check(spec); !checked) return checked;
  const bool loose = spec.mobility == Mobility::kLoose;
  PrincipalFrame frame;
  if (loose) frame = principal_frame(solid_mass_properties(spec.shapes, spec.mass_kg));
  auto shape =
      CollisionShape::make("body \"" + spec.name + "\"", spec.shapes, frame.frame_T_principal.inverse());
  if (!shape) return tl::unexpected<Error>(shape.error());
  Object object;
  object.mobility = spec.mobility;
  object.shape = std::move(*shape);
  object.body_T_frame = frame.frame_T_principal;
  btRigidBody::btRigidBodyConstructionInfo info(loose ? spec.mass_kg : 0, nullptr, object.shape.get(),
                                                loose ? to_bullet(frame.moments_kg_m2) : btVector3(0, 0, 0));
  info.m_startWorldTransform = to_bullet(spec.world_T_body * object.body_T_frame);
  info.m_friction = spec.friction;
  info.m_restitution = spec.restitution;
  info.m_rollingFriction = info.m_spinningFriction = spec.rolling_friction;
  object.body = std::make_unique<btRigidBody>(info);
  object.body->setUserIndex(static_cast<int>(ObjectKind::kBody));
  object.body->setUserIndex2(size());
  if (loose) set_loose(*object.body, thickness(spec.shapes));
  world_->bullet().addRigidBody(object.body.get(), loose ? kLooseGroup : kStaticGroup,
                                loose ? ~0 : kLooseGroup | kLinkGroup);
  objects_.push_back(std::move(object));
  return {};
}

Pose Scenery::world_T_body(int body) const {
  const Object& object = objects_[body];
  return from_bullet(object.body->getWorldTransform()) * object.body_T_frame.inverse();
}

Eigen::Vector3d Scenery::velocity(int body) const {
  const Object& object = objects_[body];
  if (object.mobility != Mobility::kLoose) return Eigen::Vector3d::Zero();
  const btVector3 to_origin = object.body->getWorldTransform().getBasis() *
                              to_bullet(object.body_T_frame.inverse().translation().eval());
  return from_bullet(object.body->getVelocityInLocalPoint(to_origin));
}

void Scenery::wake_all() {
  for (Object& object : objects_)
    if (object.mobility == Mobility::kLoose) object.body->activate(true);
}

void Scenery::place(int body, const Pose& world_T_body) {
  Object& object = objects_[body];
  btRigidBody& rigid = *object.body;
  const btTransform target = to_bullet(world_T_body * object.body_T_frame);
  rigid.setWorldTransform(target);
  rigid.setInterpolationWorldTransform(target);
  rigid.setLinearVelocity({0, 0, 0});
  rigid.setAngularVelocity({0, 0, 0});
  rigid.setInterpolationLinearVelocity({0, 0, 0});
  rigid.setInterpolationAngularVelocity({0, 0, 0});
  rigid.updateInertiaTensor();
  world_->bullet().updateSingleAabb(&rigid);
  world_->bullet().getPairCache()->cleanProxyFromPairs(rigid.getBroadphaseHandle(),
                                                       world_->bullet().getDispatcher());
  wake_all();
}

void Scenery::drive(int body, const Pose& world_T_body) {
  Object& object = objects_[body];
  btVector3 linear;
  btVector3 angular;
  btTransformUtil::calculateVelocity(object.body->getWorldTransform(),
                                     to_bullet(world_T_body * object.body_T_frame), world_->step_s(), linear,
                                     angular);
  object.body->setLinearVelocity(linear - world_->step_s() * object.body->getGravity());
  object.body->setAngularVelocity(angular);
  object.body->activate(true);
}

void Scenery::aim_person(int person, const Pose2& pose) {
  person_goals_[person] = to_pose(pose);
}

void Scenery::before_step() {
  constexpr double kJump = 5.0;  // [m/s]; what is faster was put elsewhere
  for (int i = 0; i < people(); ++i) {
    const Pose now = from_bullet(people_[i]->bullet().getWorldTransform());
    const double distance_m = (person_goals_[i].translation() - now.translation()).norm();
    if (distance_m > kJump * world_->step_s()) people_[i]->place(person_goals_[i]);
    people_[i]->aim(person_goals_[i]);
  }
}

void Scenery::after_step() {
  for (auto& person : people_) person->arrive();
}

}  // namespace extperfc::simulate
