#pragma once

#include <filesystem>

#include "extperfc/base/error.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc {

/// Probabilities at which map_server (and these functions) separate occupied, free and unknown cells.
struct MapThresholds {
  double occupied{0.65};  ///< above: occupied, (0, 1)
  double free{0.196};     ///< below: free, (0, 1), below `occupied`
};

/// Writes `<stem>.pgm` and `<stem>.yaml` as map_server's map_saver does, each by writing a neighbour file
/// first and renaming it, so that a reader never meets half a map. Errors name the file and the reason.
[[nodiscard]] Result<void> save_map(const OccupancyGrid& map, const std::filesystem::path& stem,
                                    const MapThresholds& thresholds = {});

/// Reads a map that map_server reads: a YAML file (image, resolution, origin, negate, occupied_thresh,
/// free_thresh, mode trinary | scale | raw) and the PGM image (binary or text, up to 16 bits) that it
/// names. Errors name the file, the key and the remedy (other image formats: convert them to PGM).
[[nodiscard]] Result<OccupancyGrid> load_map(const std::filesystem::path& yaml);

}  // namespace extperfc
