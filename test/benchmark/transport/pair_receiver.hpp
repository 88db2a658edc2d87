#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <message_filters/subscriber.h>
#include <message_filters/time_synchronizer.h>
#include <nodelet/detail/callback_queue.h>
#include <nodelet/detail/callback_queue_manager.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

namespace extperfc::benchmark {

/// A pair that arrived and was matched.
struct Arrival {
  double latency_us{0};  ///< from its stamp to the matched callback
  const void* color_data{nullptr};
  const void* depth_data{nullptr};
};

/// Receives pairs as a nodelet does: on a queue that the threads of a nodelet manager serve.
class PairReceiver {
 public:
  PairReceiver(const std::string& ns, nodelet::detail::CallbackQueueManager& manager);
  PairReceiver(const PairReceiver&) = delete;
  PairReceiver& operator=(const PairReceiver&) = delete;
  ~PairReceiver();

  /// Forgets what has arrived; call before sending.
  void clear();

  /// Waits for the next pair. Nothing means: none came within `deadline_s`.
  [[nodiscard]] std::optional<Arrival> wait(double deadline_s);

 private:
  void on_pair(const sensor_msgs::ImageConstPtr& color, const sensor_msgs::ImageConstPtr& depth);

  nodelet::detail::CallbackQueueManager& manager_;
  nodelet::detail::CallbackQueuePtr queue_;
  ros::NodeHandle handle_;
  message_filters::Subscriber<sensor_msgs::Image> color_;
  message_filters::Subscriber<sensor_msgs::Image> depth_;
  message_filters::TimeSynchronizer<sensor_msgs::Image, sensor_msgs::Image> synchronizer_{10};

  std::mutex mutex_;
  std::condition_variable came_;
  std::optional<Arrival> arrival_;
};

}  // namespace extperfc::benchmark
