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

/// How grey values stand for occupancy; names as in map_server's files.
enum class MapMode {
  kTrinary,  ///< occupied, free or unknown
  kScale,    ///< occupancy between the thresholds, too: 1 to 98 percent; unknown cells are transparent
  kRaw,      ///< the percentage itself; above 100: unknown
};

enum class MapImage { kPgm, kPng };

struct MapFormat {
  MapImage image{MapImage::kPgm};
  MapMode mode{MapMode::kTrinary};
};

/// Writes `<stem>.yaml` and `<stem>.pgm` (or .png) as map_server's map_saver does, each by writing a
/// neighbour file first and renaming it, so that a reader never meets half a map. Errors name the file and
/// the reason; one is unknown cells in mode scale as PGM, which has no transparent pixels.
[[nodiscard]] Result<void> save_map(const OccupancyGrid& map, const std::filesystem::path& stem,
                                    const MapThresholds& thresholds = {}, const MapFormat& format = {});

/// Reads a map that map_server reads: a YAML file (image, resolution, origin, negate, occupied_thresh,
/// free_thresh, mode trinary | scale | raw) and the image that it names: PGM (binary or text, up to 16 bits)
/// or PNG (any; colours count by their mean, transparent pixels are unknown). Errors name the file, the key
/// and the remedy.
[[nodiscard]] Result<OccupancyGrid> load_map(const std::filesystem::path& yaml);

}  // namespace extperfc
