#include "ros/offline/bag_transforms.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <console_bridge/console.h>
#include <tf2/exceptions.h>

#include "extperfc/base/text.hpp"

namespace extperfc::ros_offline {

namespace {

constexpr double kCacheS = 10.0;
constexpr double kStartsAgainS = 1.0;

Pose pose_of(const geometry_msgs::Transform& transform) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(transform.rotation.w, transform.rotation.x, transform.rotation.y,
                                     transform.rotation.z)
                      .normalized()
                      .toRotationMatrix();
  pose.translation() =
      Eigen::Vector3d(transform.translation.x, transform.translation.y, transform.translation.z);
  return pose;
}

}  // namespace

BagTransforms::BagTransforms() : buffer_(ros::Duration(kCacheS)) {
  // tf2 prints each repeated or old transform of a recording.
  console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_NONE);
}

void BagTransforms::add(const tf2_msgs::TFMessage& message, bool is_static) {
  for (const auto& transform : message.transforms) {
    const double stamp_s = transform.header.stamp.toSec();
    if (!is_static && stamp_s < newest_s_ - kStartsAgainS - kCacheS) buffer_.clear();  // static ones stay
    if (!is_static)
      newest_s_ = std::max(stamp_s, stamp_s < newest_s_ - kStartsAgainS - kCacheS ? 0.0 : newest_s_);
    try {
      (void)buffer_.setTransform(transform, "bag", is_static);
    } catch (const tf2::TransformException&) {
      continue;  // NaN, or a frame without a name
    }
  }
}

std::optional<StampedPose> BagTransforms::newest(const std::string& target, const std::string& source) const {
  if (!buffer_._frameExists(target) || !buffer_._frameExists(source)) return std::nullopt;
  try {
    const auto transform = buffer_.lookupTransform(target, source, ros::Time(0));
    return StampedPose{transform.header.stamp.toSec(), pose_of(transform.transform)};
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

std::string BagTransforms::frames() const {
  std::vector<std::string> names;
  buffer_._getFrameStrings(names);
  std::sort(names.begin(), names.end());
  return enumeration(names);
}

}  // namespace extperfc::ros_offline
