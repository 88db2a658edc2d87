#include "scan/sweep_transform.hpp"

namespace extperfc::scan {

SweepTransform::Matrix SweepTransform::matrix(const Pose& pose) {
  return pose.matrix().cast<float>();
}

SweepTransform::SweepTransform(const SensorTrack& track)
    : moves_(track.size() > 1 && track.back().time_s > track.front().time_s),
      first_s_(static_cast<float>(track.front().time_s)),
      at_stamp_(matrix(pose_at(track, 0))) {
  if (!moves_) return;
  const double duration_s = track.back().time_s - track.front().time_s;
  parts_per_s_ = static_cast<float>(kParts / duration_s);
  for (std::size_t i = 0; i <= kParts; ++i) {
    const double time_s = track.front().time_s + duration_s * static_cast<double>(i) / kParts;
    const Matrix m = matrix(pose_at(track, time_s));
    if (i < kParts) parts_[i].start = m;
    if (i > 0) parts_[i - 1].change = m - parts_[i - 1].start;
  }
}

void SweepTransform::apply(CloudPoints& points) const {
  if (!moves_ || points.time_s.empty()) return apply_one(at_stamp_, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p =
        map(points.time_s[i], {points.sensor_x[i], points.sensor_y[i], points.sensor_z[i]});
    points.x[i] = p.x();
    points.y[i] = p.y();
    points.z[i] = p.z();
  }
}

void SweepTransform::apply_one(const Matrix& m, CloudPoints& points) const {
  // Copies, which the writes below cannot alias.
  const Eigen::Vector3f along_x = m.block<3, 1>(0, 0);
  const Eigen::Vector3f along_y = m.block<3, 1>(0, 1);
  const Eigen::Vector3f along_z = m.block<3, 1>(0, 2);
  const Eigen::Vector3f origin = m.block<3, 1>(0, 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = points.sensor_x[i];
    const float y = points.sensor_y[i];
    const float z = points.sensor_z[i];
    points.x[i] = along_x.x() * x + along_y.x() * y + along_z.x() * z + origin.x();
    points.y[i] = along_x.y() * x + along_y.y() * y + along_z.y() * z + origin.y();
    points.z[i] = along_x.z() * x + along_y.z() * y + along_z.z() * z + origin.z();
  }
}

}  // namespace extperfc::scan
