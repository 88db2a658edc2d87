#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/scan_points.hpp"
#include "mapping/tracker.hpp"

namespace extperfc::mapping {

/// Follows a robot in a map that stays as it is: the tracker, with the key frames about the robot as local
/// map. What is not in the map yet is passed by odometry. Memory does not grow.
class KnownMapTracker {
 public:
  /// The robot stands at about `pose`, which the first scans correct by up to 1.2 m and 0.6 rad.
  KnownMapTracker(const OdometryNoise& noise, double minimum_fit, const Pose2& pose,
                  const Eigen::Matrix3d& covariance);

  /// `frames` must not be empty; `poses` are theirs in the map. gap_s: as of Tracker::add.
  Tracked add(const ScanPoints& points, const std::optional<Pose2>& odom_T_base, double gap_s,
              const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses);
  /// The key frames were moved: the robot moves with the one that is nearest to it.
  void follow(const std::vector<Pose2>& before, const std::vector<Pose2>& after);
  void expect_elsewhere();

  [[nodiscard]] const Pose2& pose() const { return tracker_.pose(); }  ///< in the map
  /// Of x, y, yaw in the map, as far as the latest scans and odometry know it.
  [[nodiscard]] const Eigen::Matrix3d& covariance() const { return covariance_; }

 private:
  void look_around(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses);

  Tracker motion_;   ///< in a frame of its own, which drifts
  Tracker tracker_;  ///< in the map
  Eigen::Matrix3d covariance_;
  std::optional<Pose2> looked_around_at_;
};

}  // namespace extperfc::mapping
