#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

namespace extperfc::arm {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Position error [m] and rotation vector [rad] that lead from `from` to `to`, in the frame that both are in.
[[nodiscard]] Vector6 pose_difference(const Pose& to, const Pose& from);

/// Poses joined by lines; a place on it is a length [m] from its start, a radian counting as
/// CartesianPlanner::kMetresPerRad.
class ToolPath {
 public:
  explicit ToolPath(const std::vector<Pose>& poses);

  [[nodiscard]] double length() const { return ends_.empty() ? 0.0 : ends_.back(); }
  /// The end of the line that goes on at `place`, which is below length().
  [[nodiscard]] double line_end(double place) const;
  [[nodiscard]] Pose at(double place) const;
  /// Change of the pose per metre of path, on the line that goes on at `place`.
  [[nodiscard]] Vector6 tangent(double place) const;

 private:
  struct Line {
    Pose start;
    Vector6 change;  ///< over the whole line, in the root's frame
    double length{0};
  };
  [[nodiscard]] std::size_t line_at(double place) const;

  std::vector<Line> lines_;   ///< those longer than nothing
  std::vector<double> ends_;  ///< of the lines
};

}  // namespace extperfc::arm
