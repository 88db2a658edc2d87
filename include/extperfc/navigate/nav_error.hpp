#pragma once

#include <optional>
#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

/// How a plan, a command or a whole goal ended. Stable: the numbers are those of NavCode.msg. 1xx: the
/// request, 2xx: global planning, 3xx: driving, 4xx: the robot's data.
enum class NavCode {
  kSuccess = 0,
  kInvalidRequest = 100,   ///< a value that is not finite, an unknown frame, floor or planner
  kCancelled = 101,        ///< by the client
  kReplaced = 102,         ///< by a newer goal
  kStartOutside = 200,     ///< the start is not on the map
  kGoalOutside = 201,      ///< the goal is not on the map
  kStartBlocked = 202,     ///< the footprint at the start touches an obstacle
  kGoalBlocked = 203,      ///< the footprint at the goal touches an obstacle
  kGoalUnknown = 204,      ///< the footprint at the goal touches unknown space, which is not allowed
  kNoPath = 205,           ///< start and goal are not connected
  kPlanTimeout = 206,      ///< the planner's time is over
  kBlocked = 300,          ///< no admissible velocity, and every recovery was tried
  kOscillating = 301,      ///< the robot moves without coming nearer, and every recovery was tried
  kCollisionAhead = 302,   ///< the collision guard stopped the robot, and the path stays blocked
  kNoOdometry = 400,       ///< missing or older than its limit
  kNoTransform = 401,      ///< map -> odom -> base missing or old
  kNoScan = 402,           ///< every sensor of obstacles is silent or old
  kNoMap = 403,            ///< no map yet
  kLocalizationLost = 404  ///< the localizer says so, or the pose jumps
};

/// Name of a code for logs, e.g. "goal_blocked".
[[nodiscard]] const char* to_string(NavCode code);

/// For people: what happened, where, and what to do about it, in one line.
struct NavError {
  NavCode code{NavCode::kInvalidRequest};
  std::string message;
  std::optional<Pose2> where{};  ///< in the frame of the request
};

/// "(1.25, -0.50)", for messages.
[[nodiscard]] std::string place_text(const Pose2& pose);

template <typename T>
using NavResult = tl::expected<T, NavError>;

[[nodiscard]] inline tl::unexpected<NavError> nav_fail(NavCode code, std::string message,
                                                       std::optional<Pose2> where = {}) {
  return tl::unexpected<NavError>(NavError{code, std::move(message), where});
}

}  // namespace extperfc::navigate
