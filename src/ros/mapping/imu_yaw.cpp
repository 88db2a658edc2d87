#include "ros/mapping/imu_yaw.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include <Eigen/Geometry>

namespace extperfc::ros_mapping {

namespace {

bool has_orientation(const sensor_msgs::Imu& message) {
  return message.orientation_covariance[0] >= 0;  // sensor_msgs/Imu: -1 says that there is none
}

/// Yaw of the base, or no value when the orientation is invalid.
std::optional<double> yaw_of(const sensor_msgs::Imu& message, const Eigen::Matrix3d& base_R_imu) {
  const Eigen::Quaterniond q(message.orientation.w, message.orientation.x, message.orientation.y,
                             message.orientation.z);
  if (!q.coeffs().allFinite() || q.norm() < 0.5) return std::nullopt;
  const Eigen::Matrix3d world_R_base = q.normalized().toRotationMatrix() * base_R_imu.transpose();
  return std::atan2(world_R_base(1, 0), world_R_base(0, 0));
}

}  // namespace

void ImuYaw::add(const sensor_msgs::Imu& message) {
  const double stamp_s = message.header.stamp.toSec();
  const Eigen::Vector3d omega(message.angular_velocity.x, message.angular_velocity.y,
                              message.angular_velocity.z);
  const std::lock_guard lock(mutex_);
  ++received_;
  if (frame_ != message.header.frame_id) {
    frame_ = message.header.frame_id;
    mounted_ = false;
    samples_.clear();
  }
  if (!samples_.empty() && stamp_s < samples_.back().stamp_s) samples_.clear();  // time ran back
  const bool measured = has_orientation(message);
  const auto yaw = measured ? yaw_of(message, base_R_imu_) : std::optional<double>(0.0);
  const double rate = (base_R_imu_ * omega).z();
  if (!yaw || (!measured && !std::isfinite(rate))) {
    ++ignored_;
    return;
  }
  Sample sample{stamp_s, *yaw, std::isfinite(rate) ? rate : 0.0};
  if (!samples_.empty()) {
    const auto& last = samples_.back();
    sample.yaw_rad =
        measured ? last.yaw_rad + wrap_angle(*yaw - last.yaw_rad)
                 : last.yaw_rad + 0.5 * (last.rate_rad_s + sample.rate_rad_s) * (stamp_s - last.stamp_s);
  }
  samples_.push_back(sample);
  if (samples_.size() > kKept) samples_.pop_front();
  newer_.notify_all();
}

std::optional<double> ImuYaw::interpolate(double stamp_s) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), stamp_s,
                       [](const Sample& sample, double stamp) { return sample.stamp_s < stamp; });
  if (after == samples_.end()) return std::nullopt;
  if (after->stamp_s == stamp_s) return after->yaw_rad;
  if (after == samples_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap_s = after->stamp_s - before->stamp_s;
  if (gap_s > kLongestGapS) return std::nullopt;
  const double ratio = (stamp_s - before->stamp_s) / gap_s;
  return before->yaw_rad + ratio * (after->yaw_rad - before->yaw_rad);
}

std::optional<double> ImuYaw::at(double stamp_s, double timeout_s) {
  std::unique_lock lock(mutex_);
  if (samples_.empty() || samples_.back().stamp_s < stamp_s - kLongestGapS)
    return std::nullopt;  // no publisher: do not wait
  newer_.wait_for(lock, std::chrono::duration<double>(timeout_s),
                  [&] { return closed_ || samples_.empty() || samples_.back().stamp_s >= stamp_s; });
  return interpolate(stamp_s);
}

std::string ImuYaw::unknown_frame() const {
  const std::lock_guard lock(mutex_);
  return mounted_ ? "" : frame_;
}

void ImuYaw::set_mount(const std::string& frame, const Pose& base_T_imu) {
  const std::lock_guard lock(mutex_);
  if (frame != frame_) return;
  mounted_ = true;
  if (base_R_imu_.isApprox(base_T_imu.linear(), 1e-6)) return;
  base_R_imu_ = base_T_imu.linear();
  samples_.clear();
}

void ImuYaw::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  newer_.notify_all();
}

std::size_t ImuYaw::received() const {
  const std::lock_guard lock(mutex_);
  return received_;
}

std::size_t ImuYaw::ignored() const {
  const std::lock_guard lock(mutex_);
  return ignored_;
}

}  // namespace extperfc::ros_mapping
