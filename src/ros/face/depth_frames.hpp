#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>

#include <sensor_msgs/Image.h>

namespace extperfc::ros_face {

/// The latest depth images, to be found by stamp. Any number of threads.
class DepthFrames {
 public:
  explicit DepthFrames(std::size_t kept) : kept_(kept) {}

  /// A stamp that jumps back by more than a second is a bag that starts again: forgets the images before it.
  void put(const sensor_msgs::ImageConstPtr& image);

  /// The image nearest to `stamp`, at most `tolerance_s` from it. Waits up to `wait_s` while it may still
  /// come; not when no image came since the last wait that was in vain. Null: there is none.
  [[nodiscard]] sensor_msgs::ImageConstPtr find(const ros::Time& stamp, double tolerance_s, double wait_s);

  /// Ends every wait, now and later.
  void close();

 private:
  [[nodiscard]] sensor_msgs::ImageConstPtr nearest(double stamp_s, double tolerance_s) const;

  const std::size_t kept_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<sensor_msgs::ImageConstPtr> images_;  // oldest first
  bool silent_{true};                              // no image since the last wait in vain
  bool closed_{false};
};

}  // namespace extperfc::ros_face
