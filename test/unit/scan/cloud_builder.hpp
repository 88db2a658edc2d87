#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "extperfc/scan/cloud_to_scan.hpp"

namespace extperfc::scan {

struct TestPoint {
  float x{0}, y{0}, z{0}, intensity{0};
  std::uint16_t ring{0};
  float time_s{0};  ///< since the stamp
};

/// A cloud in memory, as a VLP-16 driver lays it out: x, y, z, intensity, time as float32, ring as uint16.
class CloudBuilder {
 public:
  static constexpr std::size_t kStep = 22;  // unaligned, as drivers really do it

  explicit CloudBuilder(const std::vector<TestPoint>& points, bool big_endian = false)
      : big_endian_(big_endian), points_(points.size()) {
    for (const auto& point : points) {
      const std::size_t start = bytes_.size();
      for (const float value : {point.x, point.y, point.z, point.intensity}) append(value);
      append(point.time_s);
      append(point.ring);
      bytes_.resize(start + kStep);
    }
  }

  [[nodiscard]] CloudView view() const {
    CloudView cloud;
    cloud.data = bytes_.data();
    cloud.bytes = bytes_.size();
    cloud.width = points_;
    cloud.height = 1;
    cloud.point_step = kStep;
    cloud.row_step = kStep * points_;
    cloud.big_endian = big_endian_;
    cloud.x = {0, NumberType::kFloat32};
    cloud.y = {4, NumberType::kFloat32};
    cloud.z = {8, NumberType::kFloat32};
    cloud.intensity = CloudField{12, NumberType::kFloat32};
    cloud.time = TimeField{{16, NumberType::kFloat32}, 1.0, 0.0};
    cloud.ring = CloudField{20, NumberType::kUint16};
    return cloud;
  }

 private:
  template <typename T>
  void append(T value) {
    std::uint8_t raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big_endian_) std::reverse(raw, raw + sizeof(T));
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
  }

  bool big_endian_;
  std::size_t points_;
  std::vector<std::uint8_t> bytes_;
};

/// A dense cloud of one row over points laid out as the struct `T`; its fields are the caller's to name.
template <typename T>
CloudView packed_view(const std::vector<T>& points) {
  CloudView cloud;
  cloud.data = reinterpret_cast<const std::uint8_t*>(points.data());
  cloud.bytes = points.size() * sizeof(T);
  cloud.width = points.size();
  cloud.height = 1;
  cloud.point_step = sizeof(T);
  cloud.row_step = cloud.bytes;
  return cloud;
}

/// No limits, no ground, one degree per ray over a full revolution.
inline ScanParams open_params() {
  ScanParams params;
  params.intensity = IntensityOf::kNearest;
  params.min_height = -100;
  params.max_height = 100;
  params.angle_min = -M_PI;
  params.angle_max = M_PI;
  params.angle_increment = M_PI / 180;
  params.range_min = 0;
  params.range_max = 100;
  params.range_noise_m = 0;
  params.ground.method = GroundMethod::kNone;
  return params;
}

/// What one cloud gives.
struct Outcome {
  PlanarScan scan;  ///< the nearest points
  ScanStatistics statistics;
};
struct BothOutcomes {
  PlanarScans scans;
  ScanStatistics statistics;
};

inline BothOutcomes run_both(const ScanParams& params, const CloudView& cloud, const SensorTrack& track,
                             const SelfFilter& robot = {}) {
  auto converter = CloudToScan::make(params);
  if (!converter) throw std::runtime_error(converter.error().message);
  BothOutcomes outcome;
  auto statistics = converter->convert(cloud, track, robot, outcome.scans);
  if (!statistics) throw std::runtime_error(statistics.error().message);
  outcome.statistics = *statistics;
  return outcome;
}

inline BothOutcomes run_both(const ScanParams& params, const std::vector<TestPoint>& points,
                             const Pose& target_T_cloud = Pose::Identity(), const SelfFilter& robot = {}) {
  const CloudBuilder cloud(points);
  return run_both(params, cloud.view(), {{0, target_T_cloud}}, robot);
}

inline Outcome run(const ScanParams& params, const CloudView& cloud,
                   const Pose& target_T_cloud = Pose::Identity()) {
  auto both = run_both(params, cloud, {{0, target_T_cloud}});
  return {both.scans.nearest, both.statistics};
}

inline Outcome run(const ScanParams& params, const std::vector<TestPoint>& points,
                   const Pose& target_T_cloud = Pose::Identity()) {
  const CloudBuilder cloud(points);
  return run(params, cloud.view(), target_T_cloud);
}

/// Index of the ray that points there.
inline std::size_t ray_at(const PlanarScan& scan, double angle_rad) {
  return static_cast<std::size_t>(std::lround((angle_rad - scan.angle_min) / scan.angle_increment));
}

inline std::size_t hits(const PlanarScan& scan) {
  return static_cast<std::size_t>(std::count_if(scan.ranges.begin(), scan.ranges.end(),
                                                [](float range) { return std::isfinite(range); }));
}

}  // namespace extperfc::scan
