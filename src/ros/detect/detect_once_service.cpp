#include "ros/detect/detect_once_service.hpp"

#include <chrono>
#include <utility>

#include <boost/make_shared.hpp>

#include "ros/convert/detections.hpp"

namespace extperfc::ros_detect {

namespace {

constexpr double kDefaultTimeoutS = 5.0;

}  // namespace

DetectOnceService::DetectOnceService(ros::NodeHandle private_handle, Callbacks callbacks)
    : callbacks_(std::move(callbacks)) {
  private_handle.setCallbackQueue(&queue_);
  server_ = private_handle.advertiseService("detect_once", &DetectOnceService::serve, this);
  spinner_.start();
}

DetectOnceService::~DetectOnceService() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    if (current_) current_->close();
  }
  server_.shutdown();
  spinner_.stop();
}

bool DetectOnceService::is_waiting() const {
  const std::lock_guard lock(mutex_);
  return waiting_ != nullptr;
}

std::shared_ptr<Mailbox> DetectOnceService::take_waiting() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, nullptr);
}

bool DetectOnceService::serve(DetectOnce::Request& request, DetectOnce::Response& response) {
  const double asked_s = request.timeout.toSec();
  const double timeout_s = asked_s > 0.0 ? asked_s : kDefaultTimeoutS;
  const auto mailbox = std::make_shared<Mailbox>();
  const bool next_image = request.image.data.empty();
  {
    const std::lock_guard lock(mutex_);
    if (closing_) return false;
    current_ = mailbox;
    if (next_image) waiting_ = mailbox;
  }
  if (next_image)
    callbacks_.waiting_changed();
  else
    callbacks_.submit({boost::make_shared<sensor_msgs::Image>(request.image), false, mailbox});
  const auto answer = mailbox->take_for(std::chrono::duration<double>(timeout_s));
  const bool no_image = take_waiting() != nullptr;
  if (next_image) callbacks_.waiting_changed();

  response.success = answer && answer->output;
  if (response.success)
    response.detections = ros_convert::to_message(answer->output->detections, answer->header);
  else if (answer)
    response.message = answer->output.error().message;
  else
    response.message = (no_image ? "no image came within " : "the network had no result within ") +
                       std::to_string(timeout_s) + " s" +
                       (no_image ? ": is the camera running, and does its topic have this name?" : "");
  return true;
}

}  // namespace extperfc::ros_detect
