#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include <extperfc/DetectOnce.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/base/error.hpp"
#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stamp_matcher.hpp"

namespace extperfc::ros_depth {

/// Detects and locates objects in one image on request. Asks the detector's service for boxes, and matches
/// them with a depth image. A second request waits for the first.
///
/// Threads: a separate thread waits, so that depth images arrive meanwhile.
class DetectAndLocateService {
 public:
  using Matcher = StampMatcher<vision_msgs::Detection2DArrayConstPtr, sensor_msgs::ImageConstPtr>;
  struct Callbacks {
    std::function<void()> waiting_changed;  ///< is_waiting() changed: subscribe or unsubscribe
    /// Positions of the boxes of a pair; a null camera info means the camera's own.
    std::function<Result<vision_msgs::Detection3DArray>(const Matcher::Pair&,
                                                        const sensor_msgs::CameraInfoConstPtr&)>
        locate;
  };

  DetectAndLocateService(ros::NodeHandle handle, const Matcher::Limits& limits, Callbacks callbacks);
  /// Stops the service; a request that waits fails.
  ~DetectAndLocateService();
  DetectAndLocateService(const DetectAndLocateService&) = delete;
  DetectAndLocateService& operator=(const DetectAndLocateService&) = delete;

  /// True while a request needs depth images and camera info.
  [[nodiscard]] bool is_waiting() const;
  void on_depth(const sensor_msgs::ImageConstPtr& image);
  void on_info();

 private:
  struct Wait;

  bool serve(DetectOnce::Request& request, DetectOnce::Response& response);
  void with_image(DetectOnce& call);
  void with_camera(DetectOnce& call);
  bool detect_until(DetectOnce& call, const std::chrono::steady_clock::time_point& end);
  bool detect(DetectOnce& call);
  [[nodiscard]] bool is_closing() const;
  void locate(const Matcher::Pair& pair, const sensor_msgs::CameraInfoConstPtr& info,
              DetectOnce::Response& response);
  [[nodiscard]] std::shared_ptr<Wait> waiting() const;

  Matcher::Limits limits_;
  Callbacks callbacks_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<Wait> wait_;
  bool closing_{false};

  ros::CallbackQueue queue_;
  ros::ServiceClient detector_;
  ros::ServiceServer server_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace extperfc::ros_depth
