#pragma once

namespace extperfc::arm {

/// How a request to the arms ended. The numbers are those of the message extperfc/ArmCode, which explains
/// them; the first eight are PlanCode's.
enum class ArmCode : int {
  kSuccess = 0,
  kInvalidRequest = 1,
  kStartOutsideLimits = 2,
  kStartInCollision = 3,
  kGoalOutsideLimits = 4,
  kGoalInCollision = 5,
  kPlanningTimeout = 6,
  kCancelled = 7,
  kGoalUnreachable = 8,
  kUnknownFrame = 9,
  kNoJointStates = 10,
  kConstraintViolated = 11,
  kPathIncomplete = 12,
  kPathBlocked = 20,
  kNotFollowing = 21,
  kControllerRefused = 22,
  kControllerMissing = 23,
  kRobotNotEnabled = 24,
  kRobotStopped = 25,
  kPreempted = 26,
  kStartMoved = 27,
  kUnknownObject = 30,
  kNoGrasp = 31,
  kGraspMissed = 32,
  kObjectLost = 33,
  kNothingHeld = 34,
  kGrippersFull = 35,
  kGripperFailed = 36,
  kNotReleased = 37,
  kInternal = 99,
};

/// Name of a code for logs, e.g. "path_blocked".
[[nodiscard]] const char* to_string(ArmCode code);

}  // namespace extperfc::arm
