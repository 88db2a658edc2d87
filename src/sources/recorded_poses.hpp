#pragma once

#include <filesystem>
#include <map>
#include <optional>

#include <Eigen/Geometry>

#include "extperfc/base/error.hpp"

namespace extperfc::sources {

/// Poses of a camera over time, as TUM's RGB-D recordings store them: a line `stamp tx ty tz qx qy qz qw` per
/// pose, position [m] and orientation of the optical frame in the world, `#` comments.
class RecordedPoses {
 public:
  /// Errors name file and line.
  [[nodiscard]] static Result<RecordedPoses> load(const std::filesystem::path& file);

  /// Pose at `stamp_s`, interpolated between its neighbours. No value before the first, after the last, or in
  /// a gap of more than half a second.
  [[nodiscard]] std::optional<Eigen::Isometry3d> at(double stamp_s) const;

 private:
  std::map<double, Eigen::Isometry3d> poses_;
};

}  // namespace extperfc::sources
