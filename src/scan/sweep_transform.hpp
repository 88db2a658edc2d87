#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "extperfc/scan/sensor_track.hpp"

#include "scan/cloud_points.hpp"

namespace extperfc::scan {

/// The sensor's pose at every moment of a track, as a table: the track is cut into 32 equal parts, and the
/// matrix is interpolated linearly in each. For a rotation of w rad/s over T seconds that shortens distances
/// by (w T / 32)^2 / 8 at most: 2e-5 at 4 rad/s and 0.1 s.
class SweepTransform {
 public:
  /// Precondition: the track is not empty.
  explicit SweepTransform(const SensorTrack& track);

  [[nodiscard]] bool moves() const { return moves_; }

  /// A point of the sensor's frame in the target frame. Moments outside of the track count as its ends, and
  /// one that is no number as the stamp.
  [[nodiscard]] Eigen::Vector3f map(float time_s, const Eigen::Vector3f& point) const;

  /// Fills x, y and z. Without moments, the pose at the stamp counts for all points.
  void apply(CloudPoints& points) const;

 private:
  static constexpr std::size_t kParts = 32;
  using Matrix = Eigen::Matrix4f;  ///< homogeneous: a column is what one instruction takes
  struct Part {
    Matrix start;
    Matrix change;  ///< up to the end of the part
  };

  [[nodiscard]] static Matrix matrix(const Pose& pose);
  void apply_one(const Matrix& m, CloudPoints& points) const;

  bool moves_;
  float first_s_;
  float parts_per_s_{0};
  Matrix at_stamp_;
  std::array<Part, kParts> parts_;
};

inline Eigen::Vector3f SweepTransform::map(float time_s, const Eigen::Vector3f& p) const {
  Matrix m = at_stamp_;
  if (moves_) {
    const float since = (time_s == time_s ? time_s : 0.0F) - first_s_;
    const float part = std::clamp(since * parts_per_s_, 0.0F, static_cast<float>(kParts));
    const auto index = std::min(static_cast<std::size_t>(part), kParts - 1);
    const float ratio = part - static_cast<float>(index);
    const Part& from = parts_[index];
    m = from.start + ratio * from.change;
  }
  const Eigen::Vector4f mapped = m.col(0) * p.x() + m.col(1) * p.y() + m.col(2) * p.z() + m.col(3);
  return mapped.head<3>();
}

}  // namespace extperfc::scan
