// Proves that a motion of one's own is free of collisions, or finds how far it is.
#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/motion_pipeline.hpp"

#include "examples/robot.hpp"

using namespace extperfc;

int main() {
  const arm::RobotArms arms = examples::baxter();
  const auto* both = examples::value_of(arms.group("both_arms"));
  const auto* left = examples::value_of(arms.group("left_arm"));
  const auto standing = examples::value_of(arms.named_state(*both, "neutral"));
  const arm::JointVector from = examples::value_of(arm::RobotArms::select(*left, standing));

  arm::MotionPipeline pipeline(arms, {});
  auto checker = examples::value_of(pipeline.checker("left_arm", standing, examples::table(), false));
  const auto report = [&](const char* name, const arm::JointVector& to) {
    std::cout << name << ": ";
    if (checker.motion_free(from, to))  // every state in between, not samples
      std::cout << "proven free\n";
    else
      std::cout << "free up to " << 100 * checker.free_fraction(from, to) << " % of it\n";
    if (const auto contact = checker.contact(to))
      std::cout << "  at its end " << contact->first << " is " << -contact->distance_m << " m inside "
                << contact->second << "\n";
  };
  arm::JointVector aside = from, down = from;
  aside[0] += 0.6;  // the shoulder turns outwards
  down[1] += 0.4;   // the arm goes down, into the table
  report("aside", aside);
  report("down", down);
}
