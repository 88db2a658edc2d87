#include "ros/mapping/robot_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <tf2_eigen/tf2_eigen.h>

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_mapping {

namespace {

constexpr double kAliveS = 1.0;  ///< older odometry counts as stopped
constexpr double kStaleAfterScanS =
    0.5;                           ///< transforms so much later than a scan are from before time ran back
constexpr int kHopefulMisses = 3;  ///< scans that wait for an odometry that never came
constexpr double kPollS = 0.002;

std::string text_of(const ros::Time& stamp) {
  char text[48];
  (void)std::snprintf(text, sizeof text, "%.3f", stamp.toSec());
  return text;
}

std::string text_of(double seconds) {
  char text[48];
  (void)std::snprintf(text, sizeof text, "%.3f s", seconds);
  return text;
}

}  // namespace

Result<Pose> RobotFrames::base_T(const std::string& sensor_frame, const ros::Time& stamp, double timeout_s) {
  return lookup(base_frame_, ros_convert::without_slash(sensor_frame), stamp, timeout_s);
}

Result<Pose2> RobotFrames::odom_T_base(const ros::Time& stamp, double timeout_s) {
  const auto latest = newest(odom_frame_, base_frame_);
  const bool alive = latest && std::abs(latest->toSec() - stamp.toSec()) < kAliveS;
  const auto pose =
      lookup(odom_frame_, base_frame_, stamp, alive || misses_ < kHopefulMisses ? timeout_s : 0.0);
  if (!pose) {
    misses_ = std::min(misses_ + 1, kHopefulMisses);
    return tl::unexpected(pose.error());
  }
  misses_ = 0;
  return ros_convert::to_pose2(tf2::eigenToTransform(*pose).transform);
}

/// Polls: tf2's own wait would not end while simulated time stands still.
Result<Pose> RobotFrames::lookup(const std::string& target, const std::string& source, const ros::Time& stamp,
                                 double timeout_s) {
  if (target == source) return Pose::Identity();
  const auto deadline = ros::WallTime::now() + ros::WallDuration(timeout_s);
  while (!buffer_.canTransform(target, source, stamp) && !closing_ && ros::WallTime::now() < deadline)
    ros::WallDuration(kPollS).sleep();
  try {
    return tf2::transformToEigen(buffer_.lookupTransform(target, source, stamp));
  } catch (const tf2::TransformException&) {
    return fail(ErrorCode::kNotFound, "no transform from " + source + " to " + target +
                                          " at the scan's stamp " + text_of(stamp) + ": " +
                                          why_missing(target, source, stamp));
  }
}

std::optional<ros::Time> RobotFrames::newest(const std::string& target, const std::string& source) const {
  try {
    return buffer_.lookupTransform(target, source, ros::Time(0)).header.stamp;
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

std::string RobotFrames::why_missing(const std::string& target, const std::string& source,
                                     const ros::Time& stamp) const {
  for (const auto& frame : {source, target})
    if (!buffer_._frameExists(frame))
      return "tf does not know the frame " + frame + "; is its publisher running?";
  const auto latest = newest(target, source);
  if (!latest)
    return "tf has no connection between these frames; is the publisher of the missing transform running?";
  const double late_s = stamp.toSec() - latest->toSec();
  if (late_s > 0)
    return "the newest is " + text_of(late_s) + " older; is its publisher running, and are the clocks equal?";
  return "the newest is " + text_of(-late_s) + " later; the stamp is older than tf's buffer";
}

void RobotFrames::ran_back_to(const ros::Time& stamp, const std::string& sensor_frame) {
  bool stale = false;
  for (const auto& latest :
       {newest(odom_frame_, base_frame_), newest(base_frame_, ros_convert::without_slash(sensor_frame))})
    stale = stale || (latest && latest->toSec() > stamp.toSec() + kStaleAfterScanS);
  if (stale) buffer_.clear();
}

}  // namespace extperfc::ros_mapping
