#include "arm/collision/state_fault.hpp"

#include <sstream>

namespace extperfc::arm {

std::string text_of(const Contact& contact) {
  return contact.first + " touches " + contact.second;
}

std::optional<StateFault> outside_limits(const CollisionModel& model, const JointLimits& limits,
                                         const JointVector& state, double slack_rad,
                                         const std::string& what) {
  int worst = 0;
  if ((state - limits.upper).cwiseMax(limits.lower - state).maxCoeff(&worst) <= slack_rad)
    return std::nullopt;
  std::ostringstream message;
  message << what << " outside the limits: " << model.joint_names()[static_cast<std::size_t>(worst)]
          << " is at " << state[worst] << " rad, its limits are " << limits.lower[worst] << " to "
          << limits.upper[worst];
  return StateFault{message.str(), worst, std::nullopt};
}

StateFault in_collision(CollisionChecker& checker, const JointVector& state, const std::string& what) {
  StateFault fault{what + " in collision", -1, checker.contact(state)};
  if (fault.contact) {
    fault.message += ": " + text_of(*fault.contact);
  } else if ((fault.contact = checker.nearest(state))) {
    fault.message += ": clearance between " + fault.contact->first + " and " + fault.contact->second +
                     " too small to prove";
  }
  return fault;
}

}  // namespace extperfc::arm
