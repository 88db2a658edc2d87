#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <extperfc/EnrollFace.h>
#include <extperfc/ForgetFace.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/face/recognizer.hpp"

#include "ros/face/shared_gallery.hpp"

namespace extperfc::ros_face {

/// What the sampling of faces keeps to.
struct EnrollParams {
  int samples{5};          ///< unless the request says otherwise
  double interval_s{0.3};  ///< between two samples, by the stamps of their images
  float threshold{0};      ///< similarity with the first sample below which a face is another person's
};

/// Enrolls the face before the camera under a name, and forgets names. A second request waits for the first.
///
/// Services:
///   ~enroll  extperfc/EnrollFace: enrolls the nearest face of the next images under a name; the largest one where
///            positions are not known
///   ~forget  extperfc/ForgetFace: forgets a name and all its samples
/// Threads: a separate thread waits, so that images are processed meanwhile.
class EnrollService {
 public:
  /// `waiting_changed` is called when is_waiting() changed: subscribe or unsubscribe.
  EnrollService(ros::NodeHandle private_handle, SharedGallery& gallery, const EnrollParams& params,
                std::function<void()> waiting_changed);
  /// Stops the services; a request that waits fails.
  ~EnrollService();
  EnrollService(const EnrollService&) = delete;
  EnrollService& operator=(const EnrollService&) = delete;

  /// True while a request waits for faces.
  [[nodiscard]] bool is_waiting() const;
  /// The faces of an image, with their positions or without any. Any thread.
  void offer(const ros::Time& stamp, const std::vector<face::DescribedFace>& faces,
             const std::vector<std::optional<Eigen::Vector3d>>& positions);

 private:
  struct Sampling;

  bool enroll(EnrollFace::Request& request, EnrollFace::Response& response);
  bool forget(ForgetFace::Request& request, ForgetFace::Response& response);
  [[nodiscard]] std::shared_ptr<Sampling> current() const;
  [[nodiscard]] bool is_closing() const;
  /// False: the service ends.
  [[nodiscard]] bool begin(const std::shared_ptr<Sampling>& sampling);
  void end();
  void finish(const EnrollFace::Request& request, const Sampling& sampling, double timeout_s,
              EnrollFace::Response& response);

  SharedGallery& gallery_;
  const EnrollParams params_;
  const std::function<void()> waiting_changed_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<Sampling> current_;
  bool closing_{false};

  ros::CallbackQueue queue_;
  ros::ServiceServer enroll_server_;
  ros::ServiceServer forget_server_;
  ros::AsyncSpinner spinner_{1, &queue_};
};

}  // namespace extperfc::ros_face
