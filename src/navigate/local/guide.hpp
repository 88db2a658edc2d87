#pragma once

#include <vector>

#include "extperfc/navigate/velocity.hpp"

#include "navigate/local/path_window.hpp"

namespace extperfc::navigate {

/// Index of the station nearest to a pose in the metric of lengths, from `index` on: a few stations to either
/// side are looked at.
[[nodiscard]] std::size_t nearest_station(const std::vector<Station>& stations, std::size_t index, float x_m,
                                          float y_m, float yaw_rad);

/// A feedback controller that follows stations: the velocity of the path plus a part of the deviation. What
/// it does in the next seconds are good samples, and it knows what a random one finds late: how to pass a
/// door.
class Guide {
 public:
  Guide(const VelocityLimits& limits, BaseKind base) : limits_(limits), base_(base) {}

  /// The velocity at a pose (about the same point as the stations). `rate_factor` scales the profile; below
  /// 0: backwards along the path.
  [[nodiscard]] Twist2 velocity(const std::vector<Station>& stations, std::size_t index, const Pose2& pose,
                                double rate_factor) const;

 private:
  [[nodiscard]] Twist2 holonomic(const Station& at, const Pose2& pose, double rate) const;
  [[nodiscard]] Twist2 differential(const Station& at, const Pose2& pose, double rate) const;

  VelocityLimits limits_;
  BaseKind base_;
};

}  // namespace extperfc::navigate
