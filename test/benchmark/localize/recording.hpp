#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/trajectory.hpp"

namespace extperfc::benchmark {

/// Scans with odometry, and where the robot really was.
struct Recording {
  std::vector<LaserScan> scans;
  std::vector<Pose2> odom;
  std::vector<Pose2> truth;
};

/// The first `max_scans` scans of a CARMEN log. The truth is that of a TUM file with a line per scan or,
/// where `trajectory` is empty, what our own mapper makes of the log. Errors name the file.
[[nodiscard]] Result<Recording> load_recording(const std::filesystem::path& log,
                                               const std::filesystem::path& trajectory,
                                               std::size_t max_scans);

/// Numbers of the scans at which the robot had moved by 0.5 m or rotated by 0.5 rad since the last one.
[[nodiscard]] std::vector<std::size_t> key_frames(const Recording& recording);

/// The first, the third, ...
[[nodiscard]] std::vector<std::size_t> every_second(const std::vector<std::size_t>& frames);

/// Cells of 0.05 m, from the scans `frames`: occupied where an eighth of the rays that came by ended.
[[nodiscard]] std::shared_ptr<OccupancyGrid> draw_map(const Recording& recording,
                                                      const std::vector<std::size_t>& frames);

}  // namespace extperfc::benchmark
