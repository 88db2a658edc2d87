#pragma once

#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/sources/scan_log.hpp"

namespace extperfc::offline {

/// From one scan that is kept to the next: as far as this, or turned as far.
struct ScanSpacing {
  double way_m{0.3};
  double turn_rad{0.25};
};

/// Scans of a recording with the poses that mapping it gave them; `log` is the recording, opened anew. The
/// first scan and every one that is far enough from the last that is kept. Scans that cannot be are left out.
/// A recording that breaks off gives what came before. Memory grows with the scans that are kept.
[[nodiscard]] std::vector<sources::PlacedScan> placed_scans(sources::ScanLog& log,
                                                            const MappingResult& result,
                                                            const ScanSpacing& spacing);

}  // namespace extperfc::offline
