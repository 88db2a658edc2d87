#include "extperfc/arm/arm_code.hpp"

#include "extperfc/arm/motion_planner.hpp"

namespace extperfc::arm {

namespace {

constexpr bool same(ArmCode code, PlanCode planned) {
  return static_cast<int>(code) == static_cast<int>(planned);
}
static_assert(same(ArmCode::kSuccess, PlanCode::kSuccess));
static_assert(same(ArmCode::kInvalidRequest, PlanCode::kInvalidRequest));
static_assert(same(ArmCode::kStartOutsideLimits, PlanCode::kStartOutsideLimits));
static_assert(same(ArmCode::kStartInCollision, PlanCode::kStartInCollision));
static_assert(same(ArmCode::kGoalOutsideLimits, PlanCode::kGoalOutsideLimits));
static_assert(same(ArmCode::kGoalInCollision, PlanCode::kGoalInCollision));
static_assert(same(ArmCode::kPlanningTimeout, PlanCode::kTimeout));
static_assert(same(ArmCode::kCancelled, PlanCode::kCancelled));

}  // namespace

const char* to_string(ArmCode code) {
  switch (code) {
    case ArmCode::kSuccess:
      return "success";
    case ArmCode::kInvalidRequest:
      return "invalid_request";
    case ArmCode::kStartOutsideLimits:
      return "start_outside_limits";
    case ArmCode::kStartInCollision:
      return "start_in_collision";
    case ArmCode::kGoalOutsideLimits:
      return "goal_outside_limits";
    case ArmCode::kGoalInCollision:
      return "goal_in_collision";
    case ArmCode::kPlanningTimeout:
      return "planning_timeout";
    case ArmCode::kCancelled:
      return "cancelled";
    case ArmCode::kGoalUnreachable:
      return "goal_unreachable";
    case ArmCode::kUnknownFrame:
      return "unknown_frame";
    case ArmCode::kNoJointStates:
      return "no_joint_states";
    case ArmCode::kConstraintViolated:
      return "constraint_violated";
    case ArmCode::kPathIncomplete:
      return "path_incomplete";
    case ArmCode::kPathBlocked:
      return "path_blocked";
    case ArmCode::kNotFollowing:
      return "not_following";
    case ArmCode::kControllerRefused:
      return "controller_refused";
    case ArmCode::kControllerMissing:
      return "controller_missing";
    case ArmCode::kRobotNotEnabled:
      return "robot_not_enabled";
    case ArmCode::kRobotStopped:
      return "robot_stopped";
    case ArmCode::kPreempted:
      return "preempted";
    case ArmCode::kStartMoved:
      return "start_moved";
    case ArmCode::kUnknownObject:
      return "unknown_object";
    case ArmCode::kNoGrasp:
      return "no_grasp";
    case ArmCode::kGraspMissed:
      return "grasp_missed";
    case ArmCode::kObjectLost:
      return "object_lost";
    case ArmCode::kNothingHeld:
      return "nothing_held";
    case ArmCode::kGrippersFull:
      return "grippers_full";
    case ArmCode::kGripperFailed:
      return "gripper_failed";
    case ArmCode::kNotReleased:
      return "not_released";
    case ArmCode::kInternal:
      return "internal";
  }
  return "unknown";
}

}  // namespace extperfc::arm
