#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/drive.hpp"

namespace extperfc::benchmark {

/// Adds the score of a recording's relations: relations (scored ones), where there are any translation_m and
/// rotation_deg (means over all of them), and where there are loops, worst_loop_m. `poses` by the scan's
/// number; no value where a scan has none.
[[nodiscard]] Result<void> add_score(const Recording& recording,
                                     const std::vector<std::optional<Pose2>>& poses, Figures& figures);

/// Errors, CPU and memory in one line, for those who wait.
[[nodiscard]] std::string summary(const Figures& figures);

}  // namespace extperfc::benchmark
