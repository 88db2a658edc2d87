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

void SweepTransform::apply_one(const Matrix& matrix, CloudPoints& points) const {
  const Matrix m = matrix;  // a copy that nothing written below can be a part of
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float x = points.sensor_x[i];
    const float y = points.sensor_y[i];
    const float z = points.sensor_z[i];
    points.x[i] = m(0, 0) * x + m(0, 1) * y + m(0, 2) * z + m(0, 3);
    points.y[i] = m(1, 0) * x + m(1, 1) * y + m(1, 2) * z + m(1, 3);
    points.z[i] = m(2, 0) * x + m(2, 1) * y + m(2, 2) * z + m(2, 3);
  }
}

}  // namespace extperfc::scan
