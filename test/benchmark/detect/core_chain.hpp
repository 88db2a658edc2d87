#pragma once

#include <cstddef>

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/base/error.hpp"
#include "extperfc/depth/box_depth.hpp"
#include "extperfc/detect/detector.hpp"

namespace extperfc::benchmark {

/// Wall time of the parts [ms] and CPU time of the whole process [ms].
struct ChainTimes {
  double wrap_preprocess_ms{0};
  double inference_ms{0};
  double decode_ms{0};
  double depth_ms{0};  ///< depth of all boxes, and both result messages
  double wall_ms{0};
  double cpu_ms{0};
  std::size_t boxes{0};
};

struct InferenceTime {
  double wall_ms{0};
  double cpu_ms{0};
};

/// What the two nodelets do with a picture, called straight in one thread: no topics, queues or workers.
class CoreChain {
 public:
  CoreChain(detect::Detector detector, sensor_msgs::CameraInfo info)
      : detector_(std::move(detector)), info_(std::move(info)) {}

  [[nodiscard]] Result<ChainTimes> run(const sensor_msgs::ImageConstPtr& color,
                                       const sensor_msgs::ImageConstPtr& depth);

  /// The network alone, on the picture of the last run().
  [[nodiscard]] Result<InferenceTime> infer();

  [[nodiscard]] std::string execution() const { return detector_.execution(); }

 private:
  [[nodiscard]] Result<void> locate(const Detections& detections,
                                    const sensor_msgs::ImageConstPtr& depth) const;

  detect::Detector detector_;
  sensor_msgs::CameraInfo info_;
};

}  // namespace extperfc::benchmark
