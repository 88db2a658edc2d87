#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/footprint.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

struct GuardParams {
  double min_time_s{0.6};  ///< commands are slowed until a contact is this far ahead, (0, 10]; not below the
                           ///< time to brake from full speed plus the base's delay
  double margin_m{0.02};   ///< about the footprint that counts as contact, [0, 0.5]
  double max_age_s{0.4};   ///< of the scan, (0, 10]
  double horizon_s{2.0};   ///< contacts later than this do not count, [min_time_s, 10]
};

enum class GuardAction {
  kPassed,   ///< the command as it was
  kSlowed,   ///< the same motion, slower
  kStopped,  ///< a contact is at hand
  kNoScan,   ///< stopped: no scan yet, or older than its limit
};

struct GuardedCommand {
  Twist2 velocity;
  GuardAction action{GuardAction::kPassed};
  std::optional<double> time_s{};  ///< to the contact with the command as it was; empty: none in the horizon
  std::string reason{};            ///< why the command is not the same; empty: it is
};

/// Seconds until one of `points_m` (base's frame) touches the convex hull of a footprint grown by margin_m,
/// when the base keeps `twist`. Exact along the arc. Points within the margin count when they touch the bare
/// hull; those inside it (0) where the motion brings them deeper. Empty: not within horizon_s. O(points *
/// corners).
[[nodiscard]] std::optional<double> time_to_contact(const std::vector<Eigen::Vector2d>& points_m,
                                                    const Footprint& footprint, double margin_m,
                                                    const Twist2& twist, double horizon_s);

/// End points of a scan's returns in the base's frame [m], for the guard. A range below 1.2 m is replaced by
/// the median of the returns within two rays and 0.1 m of it: a scan has the nearest of many noisy points,
/// and a base that passes a door stands among hundreds of them. What is as narrow as one or two rays there
/// and has no neighbour stays. O(rays).
[[nodiscard]] std::vector<Eigen::Vector2d> surface_points(const LaserScan& scan);

/// The last stop before a contact, independent of cost maps and planners: commands against the points of the
/// latest scan. The motion's arc is kept, only its speed falls, so that a time to contact stays; a motion
/// away from what touches passes. One thread at a time.
class CollisionGuard {
 public:
  /// Throws std::invalid_argument for parameters out of their range.
  explicit CollisionGuard(const GuardParams& params);

  /// End points of a scan in the base's frame at stamp_s. Points that are not finite are left out.
  void set_points(std::vector<Eigen::Vector2d> points_m, double stamp_s);
  /// `velocity` is the measured one: points have moved with it since their scan.
  [[nodiscard]] GuardedCommand admit(const Footprint& footprint, const Twist2& velocity,
                                     const Twist2& command, double now_s);

 private:
  GuardParams params_;
  std::vector<Eigen::Vector2d> points_m_;
  std::vector<Eigen::Vector2d> near_m_;  ///< scratch
  std::optional<double> stamp_s_;
};

}  // namespace extperfc::navigate
