#pragma once

#include <string_view>

#include "extperfc/base/error.hpp"
#include "extperfc/sources/scan_log.hpp"

namespace extperfc::sources {

/// A FLASER line: `FLASER n ranges x y theta odom_x odom_y odom_theta stamp host logger_stamp`. Without
/// options.base_T_sensor the scanner sits `laser_offset_m` before the robot's middle.
[[nodiscard]] Result<ScanRecord> parse_flaser(std::string_view line, double laser_offset_m,
                                              const ScanLogOptions& options);

/// A ROBOTLASER1 line: `ROBOTLASER1 type start_angle field_of_view resolution maximum_range accuracy
/// remission_mode n ranges n remissions laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv
/// forward_safety_distance side_safety_distance turn_axis stamp host logger_stamp`.
[[nodiscard]] Result<ScanRecord> parse_robotlaser(std::string_view line, const ScanLogOptions& options);

}  // namespace extperfc::sources
