#include "ros/scan/imu_tilt.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::ros_scan {

void ImuTilt::add(const sensor_msgs::Imu& message) {
  const auto& q = message.orientation;
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  constexpr double kUnit = 0.1;  // how far a quaternion's length may be from 1
  const std::lock_guard lock(mutex_);
  frame_ = message.header.frame_id;
  // sensor_msgs/Imu: -1 says that there is no orientation.
  without_orientation_ = message.orientation_covariance[0] == -1 || !(std::abs(rotation.norm() - 1) < kUnit);
  if (without_orientation_) return;
  if (!samples_.empty() && message.header.stamp <= samples_.back().time)
    samples_.clear();  // a bag began again
  samples_.push_back({message.header.stamp, rotation.normalized()});
  if (samples_.size() > kKept) samples_.pop_front();
}

Result<Eigen::Quaterniond> ImuTilt::at(const ros::Time& time) const {
  constexpr double kOldest = 0.1;  // [s]
  const std::lock_guard lock(mutex_);
  if (without_orientation_)
    return fail(ErrorCode::kUnsupported,
                "the IMU gives no orientation: add an orientation filter, e.g. imu_filter_madgwick");
  if (samples_.empty()) return fail(ErrorCode::kNotFound, "no message from the IMU yet");
  const auto next = std::find_if(samples_.begin(), samples_.end(),
                                 [&](const Sample& sample) { return sample.time >= time; });
  const Sample& after = next == samples_.end() ? samples_.back() : *next;
  const Sample& before = next == samples_.begin() ? after : *(next - 1);
  const double gap_s = std::max(time.toSec() - after.time.toSec(), before.time.toSec() - time.toSec());
  if (gap_s > kOldest)
    return fail(ErrorCode::kNotFound, "the IMU's messages are " + std::to_string(gap_s) +
                                          " s away from the cloud: is it running, with the same clock?");
  const double length_s = after.time.toSec() - before.time.toSec();
  if (length_s <= 0) return after.world_R_imu;
  const double ratio = std::clamp((time.toSec() - before.time.toSec()) / length_s, 0.0, 1.0);
  return before.world_R_imu.slerp(ratio, after.world_R_imu);
}

std::string ImuTilt::frame() const {
  const std::lock_guard lock(mutex_);
  return frame_;
}

}  // namespace extperfc::ros_scan
