#pragma once

#include <optional>

#include "extperfc/world/pose.hpp"

namespace extperfc::ros_mapping {

/// Odometry for the mapper: without the jumps of a restarted odometry, and with the rotation of an IMU where
/// there is one. Its poses are those of odometry up to a rigid motion that changes at jumps only.
class OdometryChain {
 public:
  /// A motion that would need more speed is a jump. Both have a slack of 0.3 m and 0.3 rad, for late stamps.
  struct Limits {
    double max_speed_m_s{5.0};
    double max_yaw_rate_rad_s{10.0};
  };

  struct Step {
    std::optional<Pose2> odom_T_base;  ///< no value: the motion since the last step is unknown
    bool jumped{false};
    bool yaw_from_imu{false};  ///< the rotation since the last step is the IMU's
  };

  explicit OdometryChain(const Limits& limits) : limits_(limits) {}

  /// `odometry` as tf has it, `imu_yaw_rad` as ImuYaw has it, both at `stamp_s`.
  [[nodiscard]] Step next(double stamp_s, const std::optional<Pose2>& odometry,
                          std::optional<double> imu_yaw_rad);

  /// Restarts: the next pose is unrelated to earlier ones.
  void forget() { last_.reset(); }

 private:
  struct Sample {
    double stamp_s{0};
    Pose2 odometry;
    std::optional<double> imu_yaw_rad;
  };

  [[nodiscard]] bool possible(const Pose2& motion, double duration_s) const;

  const Limits limits_;
  std::optional<Sample> last_;
  std::optional<Pose2> pose_;
};

}  // namespace extperfc::ros_mapping
