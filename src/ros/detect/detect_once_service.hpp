#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <extperfc/DetectOnce.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include "ros/detect/job_queue.hpp"

namespace extperfc::ros_detect {

/// Detects objects in one image on request: the given one, or the next one of the camera. A second request
/// waits for the first.
///
/// Threads: a separate thread waits, so that images arrive meanwhile.
class DetectOnceService {
 public:
  struct Callbacks {
    std::function<void()> waiting_changed;  ///< is_waiting() changed: subscribe or unsubscribe
    std::function<void(Job)> submit;        ///< runs the network; the answer goes to the job's mailbox
  };

  DetectOnceService(ros::NodeHandle private_handle, Callbacks callbacks);
  /// Stops the service; a request that waits fails.
  ~DetectOnceService();
  DetectOnceService(const DetectOnceService&) = delete;
  DetectOnceService& operator=(const DetectOnceService&) = delete;

  /// True while a request waits for the next image.
  [[nodiscard]] bool is_waiting() const;
  /// The mailbox of the request that waits for the next image, which then waits no more; null: none does.
  [[nodiscard]] std::shared_ptr<Mailbox> take_waiting();

 private:
  bool serve(DetectOnce::Request& request, DetectOnce::Response& response);

  Callbacks callbacks_;
  mutable std::mutex mutex_;          ///< guards what follows
  std::shared_ptr<Mailbox> waiting_;  ///< for the next image
  std::shared_ptr<Mailbox> current_;  ///< of the request that is being served
  bool closing_{false};

  ros::CallbackQueue queue_;
  ros::ServiceServer server_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace extperfc::ros_detect
