#pragma once

#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/sources/scan_log.hpp"

namespace extperfc::offline {

/// Minimum translation or rotation between scans that are kept.
struct ScanSpacing {
  double distance_m{0.3};
  double rotation_rad{0.25};
};

/// Scans of a recording with the poses of its mapping result; `log` is the recording, opened again. Keeps the
/// first scan and every one that is far enough from the last kept one. Invalid scans are left out. A
/// recording that breaks off gives the scans before. Memory grows with the scans that are kept.
[[nodiscard]] std::vector<sources::PlacedScan> placed_scans(sources::ScanLog& log,
                                                            const MappingResult& result,
                                                            const ScanSpacing& spacing);

}  // namespace extperfc::offline
