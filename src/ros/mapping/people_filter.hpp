#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <extperfc/TrackArray.h>

#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::ros_mapping {

/// Leaves people out of scans, so that the map shows none of them: those whom the navigator sees walk
/// (`people_tracks`, score 1). Who stands for long is an obstacle as others. Thread-safe.
class PeopleFilter {
 public:
  explicit PeopleFilter(std::string odom_frame) : odom_frame_(std::move(odom_frame)) {}

  /// Tracks in another frame than that of odometry are not used.
  void add(const TrackArray& message);
  /// The scan without the returns of who is there at its stamp; all of it when the newest tracks are more
  /// than a second older or younger.
  [[nodiscard]] LaserScan without_people(LaserScan scan, const Pose2& odom_T_base);
  /// Returns that were left out.
  [[nodiscard]] std::uint64_t left_out() const { return left_out_; }

 private:
  struct Person {
    Eigen::Vector2d position_m;
    Eigen::Vector2d velocity_m_s;
    double radius_m;
  };

  const std::string odom_frame_;
  std::mutex mutex_;
  double stamp_s_{0};
  std::vector<Person> people_;
  std::atomic<std::uint64_t> left_out_{0};
};

}  // namespace extperfc::ros_mapping
