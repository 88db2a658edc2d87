#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

/// Maps as MRPT's programs keep them. MRPT is loaded with the first call; in a build without it every call
/// says kUnsupported. Files whose names end with .gz are packed; MRPT reads both kinds under any name.
/// Files appear whole or not at all. Any thread.
namespace extperfc::sources {

/// The name ends with .gridmap or .gridmap.gz.
[[nodiscard]] bool names_gridmap(const std::filesystem::path& file);

/// Writes an mrpt::maps::COccupancyGridMap2D. MRPT keeps the logarithm of a cell's odds in a byte, 16 steps
/// to a factor of e: free, occupied and unknown cells stay what they are, shares between move by up to 1
/// percent, and 50 percent is unknown. Errors: a map without cells, one that is turned, one whose origin is
/// no multiple of its resolution (MRPT would move it), a file that cannot be written.
[[nodiscard]] Result<void> save_gridmap(const OccupancyGrid& map, const std::filesystem::path& file);

/// Reads one. Unknown: cells of even odds. Errors name the file: missing, damaged, something else of MRPT,
/// more than 2^28 cells.
[[nodiscard]] Result<OccupancyGrid> load_gridmap(const std::filesystem::path& file);

/// A scan, and where the robot was.
struct PlacedScan {
  Pose2 map_T_base;
  LaserScan scan;
};

/// Writes an mrpt::maps::CSimpleMap: poses (Gaussians whose covariance is zero, since none is known) with the
/// scan seen there. A ray of which nothing is known is an invalid one of range 0, a ray that met nothing an
/// invalid one of the largest range. Errors: no scans, one that cannot be (its number is named), a file that
/// cannot be written.
[[nodiscard]] Result<void> save_simplemap(const std::vector<PlacedScan>& scans,
                                          const std::filesystem::path& file);

}  // namespace extperfc::sources
