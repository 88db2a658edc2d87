#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render/hash_noise.hpp"
#include "simulate/render/scene.hpp"

namespace extperfc::simulate {

inline constexpr int kRings = 16;

/// Elevation of a ring above the horizon [rad]: 2 degrees apart, ring 0 at -15.
[[nodiscard]] double ring_elevation(int ring);
/// When a ring fires within its column [s]: lasers fire in turn, low and high ones alternating.
[[nodiscard]] double ring_delay_s(int ring);

/// Sweeps of a VLP-16. Keeps its buffers from sweep to sweep.
class Lidar {
 public:
  void sweep(const LidarParams& params, const Pose& world_T_begin, const Pose& world_T_end, Scene& scene,
             std::uint64_t seed, double time_s, std::vector<LidarPoint>& points);

 private:
  /// A return before it is put in order.
  struct Return {
    float range;  ///< [m]; 0: none
    float intensity;
  };
  struct Sweep;

  /// Directions of all firings in the sensor's frame; they change with the parameters only.
  void aim(const LidarParams& params);
  void cast(const Sweep& sweep, int column, int ring);
  void measure(const Sweep& sweep, int column, int ring);

  double aimed_hz_{0};
  int aimed_columns_{0};
  std::vector<std::array<float, 3>> directions_;  ///< by column, then ring
  std::vector<float> times_;
  std::vector<Return> returns_;
  std::vector<Eigen::Isometry3f> poses_;  ///< world_T_sensor by column
  RayPacket packet_{};
  LaneMask active_{};
};

}  // namespace extperfc::simulate
