#include "ros/face/depth_frames.hpp"

#include <cmath>

namespace extperfc::ros_face {

namespace {

constexpr double kJumpS = 1.0;

double stamp_of(const sensor_msgs::ImageConstPtr& image) {
  return image->header.stamp.toSec();
}

}  // namespace

void DepthFrames::put(const sensor_msgs::ImageConstPtr& image) {
  {
    const std::lock_guard lock(mutex_);
    if (!images_.empty() && stamp_of(image) < stamp_of(images_.back()) - kJumpS) images_.clear();
    images_.push_back(image);
    if (images_.size() > kept_) images_.pop_front();
    silent_ = false;
  }
  changed_.notify_all();
}

sensor_msgs::ImageConstPtr DepthFrames::find(const ros::Time& stamp, double tolerance_s, double wait_s) {
  const double stamp_s = stamp.toSec();
  std::unique_lock lock(mutex_);
  const auto is_settled = [&] {
    return closed_ || silent_ || nearest(stamp_s, tolerance_s) || stamp_of(images_.back()) > stamp_s;
  };
  if (!changed_.wait_for(lock, std::chrono::duration<double>(wait_s), is_settled)) silent_ = true;
  return nearest(stamp_s, tolerance_s);
}

void DepthFrames::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

sensor_msgs::ImageConstPtr DepthFrames::nearest(double stamp_s, double tolerance_s) const {
  sensor_msgs::ImageConstPtr best;
  double best_s = tolerance_s;
  for (const auto& image : images_)
    if (const double apart_s = std::abs(stamp_of(image) - stamp_s); apart_s <= best_s) {
      best = image;
      best_s = apart_s;
    }
  return best;
}

}  // namespace extperfc::ros_face
