#include <array>
#include <cmath>
#include <string>

#include "extperfc/arm/grasp.hpp"

namespace extperfc::arm {
namespace {

struct Range {
  const char* name;
  double value, low, high;
};

}  // namespace

Result<void> GraspParams::validate() const {
  const std::array<Range, 14> ranges{{{"friction", friction, 0.05, 3},
                                      {"friction_ratio", friction_ratio, 0.01, 1},
                                      {"side_clearance_m", side_clearance_m, 0, 0.05},
                                      {"sigmas", sigmas, 0, 5},
                                      {"support_clearance_m", support_clearance_m, 0, 0.1},
                                      {"palm_clearance_m", palm_clearance_m, 0, 0.1},
                                      {"min_overlap_m", min_overlap_m, 0.001, 0.1},
                                      {"yaw_step_rad", yaw_step_rad, 0.05, 1.6},
                                      {"tilt_step_rad", tilt_step_rad, 0.05, 1.6},
                                      {"max_tilt_rad", max_tilt_rad, 0, 3.1416},
                                      {"prefer_top", prefer_top, 0, 0.999},
                                      {"approach_m", approach_m, 0.005, 0.5},
                                      {"lift_m", lift_m, 0, 1},
                                      {"max_candidates", static_cast<double>(max_candidates), 1, 1e4}}};
  for (const Range& range : ranges)
    if (!(range.value >= range.low && range.value <= range.high))
      return fail(ErrorCode::kInvalidArgument,
                  std::string("grasp parameter ") + range.name + " is " + std::to_string(range.value) +
                      ", it must be from " + std::to_string(range.low) + " to " + std::to_string(range.high));
  return {};
}

}  // namespace extperfc::arm
