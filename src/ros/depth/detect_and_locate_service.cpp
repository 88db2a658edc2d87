#include "ros/depth/detect_and_locate_service.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <boost/make_shared.hpp>

namespace extperfc::ros_depth {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double kDefaultTimeoutS = 5.0;
constexpr double kMaxCallS = 1.0;
constexpr double kForDepth = 0.5;  // of the time, at most, for the first depth image and camera info

double left_s(const Clock::time_point& end) {
  return std::max(0.0, Seconds(end - Clock::now()).count());
}

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
}

}  // namespace

/// What a request waits for.
struct DetectAndLocateService::Wait {
  explicit Wait(const Matcher::Limits& limits) : matcher(limits) {}

  void put_depth(const sensor_msgs::ImageConstPtr& image) {
    std::optional<Matcher::Pair> pair;
    {
      const std::lock_guard lock(mutex);
      pair = matcher.add_fast(static_cast<std::int64_t>(image->header.stamp.toNSec()), image);
    }
    first_depth.put(true);
    if (pair) pairs.put(std::move(*pair));
  }

  void put_detections(const vision_msgs::Detection2DArrayConstPtr& detections) {
    std::optional<Matcher::Pair> pair;
    {
      const std::lock_guard lock(mutex);
      pair = matcher.add_slow(static_cast<std::int64_t>(detections->header.stamp.toNSec()), detections);
    }
    if (pair) pairs.put(std::move(*pair));
  }

  void close() {
    first_depth.close();
    first_info.close();
    pairs.close();
  }

  std::mutex mutex;  // of the matcher
  Matcher matcher;
  LatestSlot<bool> first_depth;
  LatestSlot<bool> first_info;
  LatestSlot<Matcher::Pair> pairs;
};

DetectAndLocateService::DetectAndLocateService(ros::NodeHandle handle, const Matcher::Limits& limits,
                                               Callbacks callbacks)
    : limits_(limits), callbacks_(std::move(callbacks)) {
  handle.setCallbackQueue(&queue_);
  detector_ = handle.serviceClient<DetectOnce>("detector/detect_once");
  server_ = handle.advertiseService("detect_once", &DetectAndLocateService::serve, this);
  spinner_.start();
}

DetectAndLocateService::~DetectAndLocateService() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    if (wait_) wait_->close();
  }
  detector_.shutdown();
  server_.shutdown();
  spinner_.stop();
}

std::shared_ptr<DetectAndLocateService::Wait> DetectAndLocateService::waiting() const {
  const std::lock_guard lock(mutex_);
  return wait_;
}

bool DetectAndLocateService::is_waiting() const {
  return waiting() != nullptr;
}

void DetectAndLocateService::on_depth(const sensor_msgs::ImageConstPtr& image) {
  if (const auto wait = waiting()) wait->put_depth(image);
}

void DetectAndLocateService::on_info() {
  if (const auto wait = waiting()) wait->first_info.put(true);
}

bool DetectAndLocateService::serve(DetectOnce::Request& request, DetectOnce::Response& response) {
  DetectOnce call;
  call.request = request;
  if (!(call.request.timeout.toSec() > 0.0)) call.request.timeout = ros::Duration(kDefaultTimeoutS);
  if (request.image.data.empty())
    with_camera(call);
  else
    with_image(call);
  response = std::move(call.response);
  return true;
}

/// Everything is in the request.
void DetectAndLocateService::with_image(DetectOnce& call) {
  if (!detect(call)) return;
  if (call.request.depth.data.empty()) {
    call.response.message = "no 3D result: the request has an image, but no depth";
    return;
  }
  const auto info = call.request.camera_info.width > 0
                        ? boost::make_shared<const sensor_msgs::CameraInfo>(call.request.camera_info)
                        : nullptr;
  locate({boost::make_shared<const vision_msgs::Detection2DArray>(call.response.detections),
          boost::make_shared<const sensor_msgs::Image>(call.request.depth)},
         info, call.response);
}

/// The next image of the camera, and the depth image of its stamp. Depth images must already arrive when the
/// detector takes its image, or the one that belongs to it would be missed.
void DetectAndLocateService::with_camera(DetectOnce& call) {
  const double timeout_s = call.request.timeout.toSec();
  const auto end = after(timeout_s);
  const auto wait = std::make_shared<Wait>(limits_);
  {
    const std::lock_guard lock(mutex_);
    if (closing_) return;
    wait_ = wait;
  }
  callbacks_.waiting_changed();
  const auto ready = after(kForDepth * timeout_s);
  const bool sees_depth = wait->first_depth.take_for(Seconds(left_s(ready))).has_value() &&
                          wait->first_info.take_for(Seconds(left_s(ready))).has_value();
  std::optional<Matcher::Pair> pair;
  if (detect_until(call, end) && sees_depth) {
    wait->put_detections(boost::make_shared<const vision_msgs::Detection2DArray>(call.response.detections));
    pair = wait->pairs.take_for(Seconds(left_s(end)));
  }
  {
    const std::lock_guard lock(mutex_);
    wait_.reset();
  }
  callbacks_.waiting_changed();
  if (pair)
    locate(*pair, nullptr, call.response);
  else if (call.response.success)
    call.response.message = sees_depth ? "no 3D result: no depth image has the stamp of the image"
                                       : "no 3D result: no depth image, or no camera info, came in time";
}

/// Asks again and again for a second at most, since a call cannot be cancelled when this service ends.
bool DetectAndLocateService::detect_until(DetectOnce& call, const Clock::time_point& end) {
  bool detected = false;
  do {
    call.request.timeout = ros::Duration(std::clamp(left_s(end), 0.001, kMaxCallS));
    detected = detect(call);
  } while (!detected && left_s(end) > 0.0 && !is_closing());
  return detected;
}

bool DetectAndLocateService::is_closing() const {
  const std::lock_guard lock(mutex_);
  return closing_;
}

/// Asks the detector. False: `call.response` says why not.
bool DetectAndLocateService::detect(DetectOnce& call) {
  DetectOnce detector_call;
  detector_call.request.timeout = call.request.timeout;
  detector_call.request.image = call.request.image;
  if (!detector_.call(detector_call)) {
    call.response.success = false;
    call.response.message =
        "the detector's service " + detector_.getService() + " does not answer: is the detector running?";
    return false;
  }
  call.response = std::move(detector_call.response);
  return call.response.success;
}

void DetectAndLocateService::locate(const Matcher::Pair& pair, const sensor_msgs::CameraInfoConstPtr& info,
                                    DetectOnce::Response& response) {
  auto located = callbacks_.locate(pair, info);
  response.has_3d = located.has_value();
  if (located)
    response.detections_3d = std::move(*located);
  else
    response.message = "no 3D result: " + located.error().message;
}

}  // namespace extperfc::ros_depth
