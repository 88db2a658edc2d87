#include "ros/mapping/frame_publisher.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_mapping {

namespace {

constexpr double kLookS = 0.005;  ///< of wall time: how often simulated time is looked at

}  // namespace

FramePublisher::FramePublisher(Options options) : options_(std::move(options)) {
  if (options_.period_s > 0) thread_ = std::thread([this] { run(); });
}

void FramePublisher::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void FramePublisher::set(const std::string& child_frame, const Pose2& map_T_child) {
  const std::lock_guard lock(mutex_);
  transform_.emplace();
  transform_->header.frame_id = options_.map_frame;
  transform_->child_frame_id = child_frame;
  transform_->transform = ros_convert::to_transform_message(map_T_child);
}

void FramePublisher::clear() {
  const std::lock_guard lock(mutex_);
  transform_.reset();
}

void FramePublisher::run() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (const auto message = due_locked()) {
      lock.unlock();
      broadcaster_.sendTransform(*message);
      lock.lock();
    }
    const double pause_s =
        ros::Time::isSystemTime() ? options_.period_s : std::min(kLookS, options_.period_s);
    wake_.wait_for(lock, std::chrono::duration<double>(pause_s), [this] { return stopping_; });
  }
}

/// What to publish now, if anything.
std::optional<geometry_msgs::TransformStamped> FramePublisher::due_locked() {
  const auto now = ros::Time::now();
  if (now.isZero() || !transform_) return std::nullopt;  // simulated time has not begun, or no scan came
  if (now < last_now_) last_stamp_ = ros::Time();        // time ran back: so do the stamps
  last_now_ = now;
  const auto stamp = now + ros::Duration(options_.delay_s);
  const double min_period_s = ros::Time::isSystemTime() ? 0.0 : 0.99 * options_.period_s;
  if (stamp <= last_stamp_ || stamp.toSec() - last_stamp_.toSec() < min_period_s) return std::nullopt;
  last_stamp_ = stamp;
  auto message = *transform_;
  message.header.stamp = stamp;
  return message;
}

}  // namespace extperfc::ros_mapping
