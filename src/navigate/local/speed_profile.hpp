#pragma once

#include <optional>
#include <vector>

#include "extperfc/navigate/local_planner.hpp"

#include "navigate/local/clearance_field.hpp"
#include "navigate/local/path_window.hpp"

namespace extperfc::navigate {

/// How fast stations may be passed.
struct SpeedRules {
  VelocityLimits limits;
  double speed_factor{1};         ///< of zones, [0, 1]
  double narrow_speed_m_s{0.25};  ///< where the footprint nearly touches
  double wide_clearance_m{0.3};   ///< full speed from this clearance on
  bool stops_at_end{false};       ///< the last station is the goal, or blocked
};

/// Largest translation [m/s] for a clearance [m].
[[nodiscard]] float clearance_speed(const SpeedRules& rules, float clearance_m);

/// Fills clearance, cost and max_rate of stations: velocity limits along each station's motion, clearance,
/// curvature, and braking for what follows with a part of the accelerations.
void fill_speed_profile(const SpeedRules& rules, const ClearanceField& field, const Outline& outline,
                        std::vector<Station>& stations);

}  // namespace extperfc::navigate
