#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/simulate/sensor_rig.hpp"

namespace extperfc::ros_simulate {

/// What becomes of a measurement.
enum class Fate { kDelivered, kLost };

/// Faults of the camera, applied to its images. What is lost is drawn from the seed and the time of the
/// image, so it is the same in every run. One thread at a time.
class CameraFaults {
 public:
  explicit CameraFaults(std::uint64_t seed) : seed_(seed) {}

  /// True while the image that apply() would deliver is known already, so that none need be rendered.
  [[nodiscard]] bool frozen(const std::vector<simulate::Fault>& active) const;

  /// Changes `images`, a new image, to what the faulty camera delivers; while frozen(), `images` is only
  /// written. `time_s` is when the image was taken.
  [[nodiscard]] Fate apply(const std::vector<simulate::Fault>& active, double time_s,
                           simulate::CameraImages& images);

 private:
  std::uint64_t seed_;
  bool kept_{false};
  simulate::CameraImages frozen_;  ///< the first image of the freeze
};

/// Faults of the lidar, applied to its sweeps. As CameraFaults.
class LidarFaults {
 public:
  explicit LidarFaults(std::uint64_t seed) : seed_(seed) {}

  [[nodiscard]] Fate apply(const std::vector<simulate::Fault>& active, double time_s,
                           std::vector<simulate::LidarPoint>& points) const;

 private:
  std::uint64_t seed_;
};

}  // namespace extperfc::ros_simulate
