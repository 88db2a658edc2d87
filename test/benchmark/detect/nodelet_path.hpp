#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include <nodelet/loader.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <vision_msgs/Detection3DArray.h>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"

#include "test/benchmark/detect/core_chain.hpp"

namespace extperfc::benchmark {

/// What a camera driver publishes for one moment.
struct CameraMessages {
  sensor_msgs::ImagePtr color;
  sensor_msgs::ImagePtr depth;
  sensor_msgs::CameraInfoPtr info;
};

struct PathCost {
  Cost cost;  ///< from the camera's first publish() to the callback with the 3D detections
  std::size_t objects{0};
};

/// The nodelets detector and box_depth in a nodelet manager inside this process, under a namespace of their
/// own.
class NodeletPath {
 public:
  struct Settings {
    std::filesystem::path model;
    detect::InferenceOptions inference;
    double score_threshold{-1.0};  ///< negative = the model's own
  };

  /// Loads the nodelets and waits until every topic is connected.
  /// Errors: kFailed when a nodelet refuses to start or nothing connects.
  [[nodiscard]] Result<void> start(const std::string& ns, const Settings& settings);

  NodeletPath() = default;
  NodeletPath(const NodeletPath&) = delete;
  NodeletPath& operator=(const NodeletPath&) = delete;
  ~NodeletPath();

  /// Stamps and publishes one moment and waits for its result. kFailed when none comes.
  [[nodiscard]] Result<PathCost> run(const CameraMessages& messages);

 private:
  void connect(const std::string& ns);
  [[nodiscard]] Result<void> load(const std::string& ns, const Settings& settings);
  [[nodiscard]] Result<void> wait_for_subscribers();

  ros::CallbackQueue queue_;  ///< of our subscriber; served by run()
  std::optional<ros::NodeHandle> handle_;
  ros::Publisher color_;
  ros::Publisher depth_;
  ros::Publisher info_;
  ros::Subscriber objects_;
  vision_msgs::Detection3DArrayConstPtr newest_;
  std::optional<nodelet::Loader> loader_;
};

}  // namespace extperfc::benchmark
