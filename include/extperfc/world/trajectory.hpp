#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc {

struct StampedPose2 {
  double stamp_s{0};  ///< [s]
  Pose2 pose;         ///< in the trajectory's fixed frame
};

/// Poses in the order in which they were passed. Stamps of recordings may run backwards.
using Trajectory = std::vector<StampedPose2>;

/// TUM format: `stamp x y z qx qy qz qw` a line, z = 0, `#` comments. Errors name the file and the line.
[[nodiscard]] Result<void> write_tum(const Trajectory& trajectory, const std::filesystem::path& file);
[[nodiscard]] Result<Trajectory> read_tum(const std::filesystem::path& file);

}  // namespace extperfc
