#pragma once

#include <string>

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

namespace extperfc::benchmark {

/// What an RGB-D camera publishes for one moment: 640 x 480, rgb8 and 16UC1.
struct ImagePair {
  sensor_msgs::ImagePtr color;
  sensor_msgs::ImagePtr depth;
};

[[nodiscard]] ImagePair make_pair();

/// Publishes pairs on `<ns>/color` and `<ns>/depth`.
class PairSender {
 public:
  explicit PairSender(const std::string& ns);

  /// Both topics have a subscriber.
  [[nodiscard]] bool connected() const;

  /// Stamps and publishes as pointers: receivers in this process get the same memory.
  void send_pointers(const ImagePair& pair);

  /// Stamps and publishes by const reference, which roscpp always serialises.
  void send_references(const ImagePair& pair);

 private:
  ros::NodeHandle handle_;
  ros::Publisher color_;
  ros::Publisher depth_;
};

}  // namespace extperfc::benchmark
