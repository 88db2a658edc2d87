#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2_ros/transform_broadcaster.h>

#include "extperfc/world/pose.hpp"

namespace extperfc::ros_mapping {

/// Publishes map -> odom (or map -> base without odometry) periodically, independent of scans, stamped ahead
/// by `delay_s` so that lookups at the present time succeed. The same stamp is never published twice.
class FramePublisher {
 public:
  struct Options {
    std::string map_frame;
    double period_s{0.05};  ///< 0: publishes nothing
    double delay_s{0.05};
  };

  explicit FramePublisher(Options options);
  ~FramePublisher() { stop(); }
  FramePublisher(const FramePublisher&) = delete;
  FramePublisher& operator=(const FramePublisher&) = delete;

  void set(const std::string& child_frame, const Pose2& map_T_child);
  /// Stops publishing until the next set().
  void clear();
  /// Returns when no publishing is under way. Harmless twice.
  void stop();

 private:
  void run();
  [[nodiscard]] std::optional<geometry_msgs::TransformStamped> due_locked();

  const Options options_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<geometry_msgs::TransformStamped> transform_;
  ros::Time last_now_;
  ros::Time last_stamp_;
  bool stopping_{false};
  std::thread thread_;
};

}  // namespace extperfc::ros_mapping
