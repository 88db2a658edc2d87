// Plans a motion of the left arm over a table, from the request to the trajectory for a controller.
#include "extperfc/arm/motion_pipeline.hpp"

#include "examples/robot.hpp"

using namespace extperfc;

int main() {
  const arm::RobotArms arms = examples::baxter();
  const auto* both = examples::value_of(arms.group("both_arms"));
  arm::MotionPipeline pipeline(arms, {});

  arm::MotionRequest request;
  request.group = "left_arm";
  request.start = examples::value_of(arms.named_state(*both, "neutral"));  // of every joint that is known
  request.goal =
      arm::JointPositions{{"left_s0", 0.6}, {"left_w1", 0.8}};  // or a state's name, or a tool's pose
  request.velocity_scale = 0.5;
  request.seed = 1;

  const arm::MotionOutcome outcome = pipeline.plan(request, examples::table());
  std::cout << outcome.message << "\n";
  if (outcome.code != arm::ArmCode::kSuccess) return 1;
  std::cout << outcome.waypoints.size() << " waypoints, " << outcome.points.size() << " points:\n";
  for (const auto& point : outcome.points)
    std::cout << point.time_s << " s  " << point.position.transpose() << "\n";
}
