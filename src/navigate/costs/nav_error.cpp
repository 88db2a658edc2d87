#include "extperfc/navigate/nav_error.hpp"

#include <array>
#include <cstdio>

namespace extperfc::navigate {

const char* to_string(NavCode code) {
  switch (code) {
    case NavCode::kSuccess:
      return "success";
    case NavCode::kInvalidRequest:
      return "invalid_request";
    case NavCode::kCancelled:
      return "cancelled";
    case NavCode::kReplaced:
      return "replaced";
    case NavCode::kStartOutside:
      return "start_outside";
    case NavCode::kGoalOutside:
      return "goal_outside";
    case NavCode::kStartBlocked:
      return "start_blocked";
    case NavCode::kGoalBlocked:
      return "goal_blocked";
    case NavCode::kGoalUnknown:
      return "goal_unknown";
    case NavCode::kNoPath:
      return "no_path";
    case NavCode::kPlanTimeout:
      return "plan_timeout";
    case NavCode::kBlocked:
      return "blocked";
    case NavCode::kOscillating:
      return "oscillating";
    case NavCode::kCollisionAhead:
      return "collision_ahead";
    case NavCode::kNoOdometry:
      return "no_odometry";
    case NavCode::kNoTransform:
      return "no_transform";
    case NavCode::kNoScan:
      return "no_scan";
    case NavCode::kNoMap:
      return "no_map";
    case NavCode::kLocalizationLost:
      return "localization_lost";
  }
  return "unknown";
}

std::string place_text(const Pose2& pose) {
  std::array<char, 64> text{};
  (void)std::snprintf(text.data(), text.size(), "(%.2f, %.2f)", pose.x, pose.y);
  return text.data();
}

}  // namespace extperfc::navigate
