#include "ros/sources/recording_player.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <cv_bridge/cv_bridge.h>
#include <ros/console.h>
#include <ros/init.h>
#include <sensor_msgs/image_encodings.h>
#include <tf2_eigen/tf2_eigen.h>

#include "ros/convert/image.hpp"

namespace extperfc::ros_sources {

namespace {

/// Intrinsics for a recording that brings none: the nominal focal length of a PrimeSense/Kinect v1 class
/// camera, 525 px at 640 pixels width, and the image's middle.
CameraModel assumed_camera(int width, int height) {
  const double focal_px = 525.0 / 640.0 * width;
  return {width, height, focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1), {}};
}

sensor_msgs::ImagePtr to_message(const cv::Mat& image) {
  namespace enc = sensor_msgs::image_encodings;
  if (image.empty()) return nullptr;
  const std::string encoding = image.type() == CV_16UC1  ? enc::TYPE_16UC1
                               : image.type() == CV_8UC1 ? enc::MONO8
                                                         : enc::BGR8;
  return cv_bridge::CvImage(std_msgs::Header(), encoding, image).toImageMsg();
}

void add_last(diagnostic_updater::DiagnosticStatusWrapper& status, const char* key,
              const sensor_msgs::ImagePtr& image) {
  if (!image) return;
  const auto& stamp = image->header.stamp;
  status.addf(key, "%u.%09u @ %p", stamp.sec, stamp.nsec, static_cast<const void*>(image->data.data()));
}

}  // namespace

RecordingPlayer::RecordingPlayer(ros::NodeHandle handle, ros_params::SourceParams params,
                                 std::unique_ptr<sources::Recording> recording)
    : params_(std::move(params)), recording_(std::move(recording)) {
  camera_ = params_.camera ? params_.camera : recording_->camera();
  color_publisher_ = handle.advertise<sensor_msgs::Image>("camera/color/image_raw", 2);
  color_info_publisher_ = handle.advertise<sensor_msgs::CameraInfo>("camera/color/camera_info", 2);
  depth_publisher_ = handle.advertise<sensor_msgs::Image>("camera/aligned_depth_to_color/image_raw", 2);
  depth_info_publisher_ =
      handle.advertise<sensor_msgs::CameraInfo>("camera/aligned_depth_to_color/camera_info", 2);
  thread_ = std::thread([this] { play(); });
}

RecordingPlayer::~RecordingPlayer() {
  stopping_ = true;
  stop_.close();
  thread_.join();
}

void RecordingPlayer::play() {
  if (!wait_for_listener()) return;
  auto due = ros::WallTime::now();
  std::optional<Messages> previous;
  do {
    for (std::size_t index = 0; index < recording_->size(); ++index) {
      const auto messages = read(index);  // read ahead of its time
      if (!messages) continue;
      if (previous) due += ros::WallDuration(period_to(*previous, *messages));
      due = std::max(due, ros::WallTime::now() - ros::WallDuration(1.0));  // no burst after a stall
      if (!sleep_until(due)) return;
      publish(*messages);
      previous = messages;
    }
    // A recording without readable frames must not spin.
    if (!previous && !sleep_until(ros::WallTime::now() + ros::WallDuration(1.0))) return;
  } while (params_.loop && !stopping_);
  finished_ = true;
  ROS_INFO("the recording %s is played to its end", params_.path.c_str());
}

/// False when the player is stopped meanwhile.
bool RecordingPlayer::wait_for_listener() {
  const auto listened = [this] {
    return color_publisher_.getNumSubscribers() > 0 || depth_publisher_.getNumSubscribers() > 0;
  };
  if (!params_.wait_for_subscriber) return !stopping_;
  while (!listened())
    if (!sleep_until(ros::WallTime::now() + ros::WallDuration(0.05))) return false;
  // One listener rarely comes alone: the others of its pipeline connect within a moment and want the first
  // frame too.
  return sleep_until(ros::WallTime::now() + ros::WallDuration(0.5));
}

bool RecordingPlayer::sleep_until(ros::WallTime when) {
  const double seconds = (when - ros::WallTime::now()).toSec();
  if (seconds > 0.0) (void)stop_.take_for(std::chrono::duration<double>(seconds));
  return !stopping_ && ros::ok();
}

std::optional<RecordingPlayer::Messages> RecordingPlayer::read(std::size_t index) {
  auto frame = recording_->frame(index);
  if (!frame) {
    if (unreadable_++ == 0) ROS_ERROR("%s; going on with the next frame", frame.error().message.c_str());
    return std::nullopt;
  }
  Messages messages{to_message(frame->color), to_message(frame->depth), std::nullopt, frame->stamp_s};
  if (frame->world_T_optical)
    messages.world_T_optical = tf2::eigenToTransform(*frame->world_T_optical).transform;
  return messages;
}

double RecordingPlayer::period_to(const Messages& previous, const Messages& next) const {
  constexpr double kDefaultPeriodS = 1.0 / 30.0;
  constexpr double kLongestPauseS = 10.0;
  if (params_.rate_hz > 0.0) return 1.0 / params_.rate_hz;
  const double recorded_s = next.recorded_s - previous.recorded_s;
  return recorded_s > 0.0 && recorded_s < kLongestPauseS ? recorded_s
                                                         : kDefaultPeriodS;  // else: the loop's seam
}

CameraModel RecordingPlayer::camera_of(const sensor_msgs::Image& image) {
  if (!camera_) {
    camera_ = assumed_camera(static_cast<int>(image.width), static_cast<int>(image.height));
    ROS_WARN(
        "%s brings no intrinsics: assuming fx = fy = %.1f px; positions are approximate until you give a "
        "camera_info file",
        params_.path.c_str(), camera_->fx);
  }
  return *camera_;
}

void RecordingPlayer::publish(const Messages& messages) {
  std_msgs::Header header;
  header.frame_id = params_.frame_id;
  header.stamp = params_.recorded_stamps ? ros::Time(messages.recorded_s) : ros::Time::now();
  const auto& sample = messages.color ? messages.color : messages.depth;
  if (!sample) return;
  if (messages.world_T_optical) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = header.stamp;
    transform.header.frame_id = params_.world_frame;
    transform.child_frame_id = params_.frame_id;
    transform.transform = *messages.world_T_optical;
    tf_broadcaster_.sendTransform(transform);
  }
  const auto info =
      boost::make_shared<sensor_msgs::CameraInfo>(ros_convert::to_camera_info(camera_of(*sample), header));
  color_info_publisher_.publish(info);
  depth_info_publisher_.publish(info);
  if (messages.depth) {  // before colour, so that it waits for the detections and not they for it
    messages.depth->header = header;
    depth_publisher_.publish(messages.depth);
  }
  if (messages.color) {
    messages.color->header = header;
    color_publisher_.publish(messages.color);
  }
  remember(messages);
  ++played_;
}

void RecordingPlayer::remember(const Messages& messages) {
  const std::lock_guard lock(last_mutex_);
  last_ = messages;
}

void RecordingPlayer::report(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, finished_ ? "played to its end" : "playing");
  status.add("recording", params_.path.string());
  status.add("frames", recording_->size());
  status.add("played", played_.load());
  status.add("unreadable", unreadable_.load());
  {
    const std::lock_guard lock(last_mutex_);
    add_last(status, "color last", last_.color);
    add_last(status, "depth last", last_.depth);
  }
  if (unreadable_ > 0)
    status.mergeSummaryf(diagnostic_msgs::DiagnosticStatus::WARN, "%lu frames could not be read",
                         static_cast<unsigned long>(unreadable_.load()));
}

}  // namespace extperfc::ros_sources
