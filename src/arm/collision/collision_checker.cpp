#include "extperfc/arm/collision_checker.hpp"

#include <utility>

#include "arm/collision/checks.hpp"

namespace extperfc::arm {

Result<CollisionChecker> CollisionChecker::make(const CollisionModel& model, const CollisionWorld& world,
                                                const CollisionCheckerParams& params) {
  if (!(params.min_step_rad >= 1e-5 && params.min_step_rad <= 0.1))
    return fail(ErrorCode::kInvalidArgument, "min_step_rad must be from 1e-5 to 0.1 rad");
  auto scene = make_scene(model.bodies(), world);
  if (!scene) return tl::unexpected<Error>(scene.error());
  return CollisionChecker(std::make_unique<Checks>(model, world, params, std::move(*scene)));
}

CollisionChecker::CollisionChecker(std::unique_ptr<Checks> checks) : checks_(std::move(checks)) {}
CollisionChecker::CollisionChecker(CollisionChecker&&) noexcept = default;
CollisionChecker& CollisionChecker::operator=(CollisionChecker&&) noexcept = default;
CollisionChecker::~CollisionChecker() = default;

CollisionChecker CollisionChecker::clone() const {
  return std::move(*make(checks_->model, checks_->world, checks_->params));  // made once before: cannot fail
}

bool CollisionChecker::is_free(const JointVector& positions) {
  return checks_->states_free(&positions, 1, true)[0];
}

std::vector<bool> CollisionChecker::are_free(const std::vector<JointVector>& states) {
  return checks_->states_free(states.data(), static_cast<int>(states.size()), true);
}

std::vector<bool> CollisionChecker::spheres_free(const std::vector<JointVector>& states) {
  return checks_->states_free(states.data(), static_cast<int>(states.size()), false);
}

std::optional<Contact> CollisionChecker::contact(const JointVector& positions) {
  return checks_->contact(positions);
}

std::optional<Contact> CollisionChecker::nearest(const JointVector& positions) {
  return checks_->nearest(positions);
}

bool CollisionChecker::motion_free(const JointVector& from, const JointVector& to, double deviation_rad) {
  return checks_->free_fraction(from, to, true, deviation_rad) >= 1;
}

double CollisionChecker::free_fraction(const JointVector& from, const JointVector& to) {
  return checks_->free_fraction(from, to, false);
}

const CollisionModel& CollisionChecker::model() const {
  return checks_->model;
}

const CollisionWorld& CollisionChecker::world() const {
  return checks_->world;
}

const CollisionCounters& CollisionChecker::counters() const {
  return checks_->counters;
}

}  // namespace extperfc::arm
