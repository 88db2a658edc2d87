#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include <extperfc/TrackArray.h>
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/track/tracker.hpp"

#include "ros/convert/tracks.hpp"
#include "ros/health/reporter.hpp"
#include "ros/health/stream_health.hpp"
#include "ros/params/tracker_params.hpp"

namespace extperfc::ros_track {

/// Follows detected objects from image to image: an id for each, and a Kalman filter of its position and
/// velocity.
///
/// Subscribes (only while the output has subscribers):
///   detections_3d  vision_msgs/Detection3DArray: positions with their covariances
/// Publishes:
///   objects/tracks  extperfc/TrackArray, one for each detections_3d: confirmed objects with id, class, filtered
///                   position and velocity; those that were not detected in this image are predicted
///   diagnostics     diagnostic_msgs/DiagnosticArray
/// Parameters: config/tracker.yaml.
/// Frames: needs frame of the detections -> fixed_frame at their stamp when fixed_frame is set. With a camera
///   that moves, objects are followed well in a frame that stands still only.
/// Diagnostics: objects, rates, latency; images that came too late, restarts after time ran back; ERROR while
///   a transform is missing.
/// Threads: the callback stores the message; one worker filters. The newest replaces a waiting one.
class TrackerNodelet : public nodelet::Nodelet {
 public:
  ~TrackerNodelet() override {
    reporter_.reset();
    {
      const std::lock_guard lock(subscription_mutex_);
      closing_ = true;  // a listener that comes or goes now must not subscribe again
    }
    subscriber_.shutdown();
    waiting_.close();
    if (worker_.joinable()) worker_.join();
  }

 private:
  using Message = vision_msgs::Detection3DArray;
  static constexpr const char* kTopic = "detections_3d";

  void onInit() override;
  void update_subscription();
  void process(const Message& message);
  Result<Eigen::Isometry3d> transform_at(const std_msgs::Header& header) const;
  /// False: the message is older than the latest one.
  bool follow(const Message& message, const Eigen::Isometry3d& target_T_source);
  [[nodiscard]] TrackArrayPtr tracks_at(const std_msgs::Header& header) const;
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros_params::TrackerNodeletParams params_;
  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::optional<ros_health::Reporter> reporter_;
  ros_health::InputHealth input_{"detections"};
  ros_health::WorkHealth work_health_;

  std::mutex subscription_mutex_;
  bool closing_{false};
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;

  // Of the worker.
  std::optional<track::Tracker> tracker_;
  std::map<std::uint64_t, ros_convert::TrackedBody> bodies_;  // by the ids of the tracks

  std::mutex counts_mutex_;  ///< guards what follows
  std::size_t objects_{0};
  std::uint64_t too_late_{0};
  std::uint64_t restarts_{0};

  LatestSlot<Message::ConstPtr> waiting_;
  std::thread worker_;
};

void TrackerNodelet::onInit() {
  const auto params = ros_params::load_tracker_params(getPrivateNodeHandle());
  if (!params) {
    NODELET_FATAL("%s", params.error().message.c_str());
    throw std::runtime_error(params.error().message);
  }
  params_ = *params;
  tracker_.emplace(params_.tracker);
  if (!params_.fixed_frame.empty()) {
    tf_buffer_ = std::make_unique<tf2_ros::Buffer>();
    tf_listener_ = std::make_unique<tf2_ros::TransformListener>(*tf_buffer_);
  }
  worker_ = std::thread([this] {
    while (const auto message = waiting_.take()) process(**message);
  });
  {
    const std::lock_guard lock(subscription_mutex_);
    const auto changed = [this](const ros::SingleSubscriberPublisher&) { update_subscription(); };
    publisher_ = getNodeHandle().advertise<TrackArray>("objects/tracks", 5, changed, changed);
  }
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName());
  reporter_->add("tracker", [this](auto& status) { report(status); });
  reporter_->start();
}

void TrackerNodelet::update_subscription() {
  const std::lock_guard lock(subscription_mutex_);
  if (closing_) return;
  const bool wanted = publisher_.getNumSubscribers() > 0;
  input_.listening(wanted);
  if (!wanted) return subscriber_.shutdown();
  if (subscriber_) return;
  subscriber_ = getNodeHandle().subscribe<Message>(
      kTopic, 5,
      boost::function<void(const ros::MessageEvent<const Message>&)>(
          [this](const ros::MessageEvent<const Message>& event) {
            const auto& message = event.getConstMessage();
            input_.received(message->header.stamp, message.get(), ros_health::came_by_pointer(event));
            waiting_.put(message);
          }));
}

void TrackerNodelet::process(const Message& message) {
  const Stopwatch watch;
  const auto target_T_source = transform_at(message.header);
  if (!target_T_source) {
    if (work_health_.failed(target_T_source.error().message))
      NODELET_ERROR("%s", target_T_source.error().message.c_str());
    return;
  }
  if (!follow(message, *target_T_source)) return;
  auto header = message.header;
  if (!params_.fixed_frame.empty()) header.frame_id = params_.fixed_frame;
  publisher_.publish(tracks_at(header));
  work_health_.done(watch.milliseconds(), ros_health::age_ms(header.stamp));
}

Result<Eigen::Isometry3d> TrackerNodelet::transform_at(const std_msgs::Header& header) const {
  if (params_.fixed_frame.empty()) return Eigen::Isometry3d::Identity();
  try {
    return tf2::transformToEigen(tf_buffer_->lookupTransform(
        params_.fixed_frame, header.frame_id, header.stamp, ros::Duration(params_.transform_timeout_s)));
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound, "no transform from " + header.frame_id + " to " + params_.fixed_frame +
                                          " at the stamp of the detections; is tf published?");
  }
}

bool TrackerNodelet::follow(const Message& message, const Eigen::Isometry3d& target_T_source) {
  const auto status =
      tracker_->update(message.header.stamp.toSec(), ros_convert::to_observations(message, target_T_source));
  const std::lock_guard lock(counts_mutex_);
  if (status == track::Tracker::Status::kTooOld) {
    ++too_late_;
    return false;
  }
  if (status == track::Tracker::Status::kRestarted) ++restarts_;
  std::map<std::uint64_t, ros_convert::TrackedBody> bodies;
  for (const auto& track : tracker_->tracks())
    bodies[track.id] = track.observation
                           ? ros_convert::body_of(message.detections[*track.observation], target_T_source)
                           : bodies_[track.id];
  bodies_ = std::move(bodies);
  objects_ = bodies_.size();
  return true;
}

TrackArrayPtr TrackerNodelet::tracks_at(const std_msgs::Header& header) const {
  auto array = boost::make_shared<TrackArray>();
  array->header = header;
  for (const auto& track : tracker_->tracks())
    if (track.confirmed || params_.publish_tentative)
      array->tracks.push_back(ros_convert::to_message(track, bodies_.at(track.id)));
  return array;
}

void TrackerNodelet::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, "running");
  status.add("dropped", waiting_.dropped());
  input_.report(status, getNodeHandle().resolveName(kTopic), params_.timeout_s);
  work_health_.report(status);
  const std::lock_guard lock(counts_mutex_);
  status.add("objects", objects_);
  status.add("too late", too_late_);
  status.add("restarts", restarts_);
}

}  // namespace extperfc::ros_track

PLUGINLIB_EXPORT_CLASS(extperfc::ros_track::TrackerNodelet, nodelet::Nodelet)
