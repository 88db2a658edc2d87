#pragma once

#include <string>
#include <vector>

#include <rosbag/bag.h>

#include "extperfc/base/error.hpp"
#include "extperfc/offline/recording.hpp"

namespace extperfc::ros_offline {

/// What is read of a bag.
struct BagTopics {
  std::string scan;
  std::string odometry;             ///< nav_msgs/Odometry; empty: there is none
  std::vector<std::string> moving;  ///< /tf
  std::vector<std::string> fixed;   ///< /tf_static
};

/// Errors: no or several topics to choose from, a topic that is not there or of another type; they list what
/// there is.
[[nodiscard]] Result<BagTopics> choose_topics(const rosbag::Bag& bag,
                                              const offline::RecordingOptions& options);

}  // namespace extperfc::ros_offline
