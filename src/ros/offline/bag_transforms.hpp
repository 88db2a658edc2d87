#pragma once

#include <optional>
#include <string>

#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include "extperfc/world/pose.hpp"

namespace extperfc::ros_offline {

struct StampedPose {
  double stamp_s{0};
  Pose pose;
};

/// The transforms of a bag, without a node.
class BagTransforms {
 public:
  BagTransforms();

  /// Damaged transforms are passed over. A recording whose time runs back by more than a second starts again.
  void add(const tf2_msgs::TFMessage& message, bool is_static);
  /// The newest transform that all links between the two frames have in common; no value when they are not
  /// linked.
  [[nodiscard]] std::optional<StampedPose> newest(const std::string& target, const std::string& source) const;
  /// For an error's text: "base_link, laser, odom".
  [[nodiscard]] std::string frames() const;

 private:
  tf2::BufferCore buffer_;
  double newest_s_{0};
};

}  // namespace extperfc::ros_offline
