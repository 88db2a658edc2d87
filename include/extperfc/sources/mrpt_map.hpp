#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

/// Maps in MRPT's formats. MRPT is loaded with the first call; in a build without it every call returns
/// kUnsupported. Files whose names end with .gz are packed; MRPT reads both kinds under any name. Files are
/// written atomically. Any thread.
namespace extperfc::sources {

/// The name ends with .gridmap or .gridmap.gz.
[[nodiscard]] bool names_gridmap(const std::filesystem::path& file);

/// Writes an mrpt::maps::COccupancyGridMap2D. MRPT keeps the logarithm of a cell's odds in a byte, 16 steps
/// to a factor of e: free, occupied and unknown cells are exact, probabilities between move by up to 1
/// percent, and 50 percent is unknown. Errors: a map without cells, a rotated one, one whose origin is
/// no multiple of its resolution (MRPT would move it), a file that cannot be written.
[[nodiscard]] Result<void> save_gridmap(const OccupancyGrid& map, const std::filesystem::path& file);

/// Reads one. Unknown: cells of even odds. Errors name the file: missing, damaged, another MRPT object,
/// more than 2^28 cells.
[[nodiscard]] Result<OccupancyGrid> load_gridmap(const std::filesystem::path& file);

/// A scan with the robot's pose.
struct PlacedScan {
  Pose2 map_T_base;
  LaserScan scan;
};

/// Writes an mrpt::maps::CSimpleMap: poses (Gaussians whose covariance is zero, since none is known) with the
/// scan seen there. An unknown ray is an invalid one of range 0, a ray without return an invalid one of
/// the largest range. Errors: no scans, an invalid one (its number is named), a file that cannot be written.
[[nodiscard]] Result<void> save_simplemap(const std::vector<PlacedScan>& scans,
                                          const std::filesystem::path& file);

}  // namespace extperfc::sources
