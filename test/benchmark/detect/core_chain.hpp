#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include "extperfc/base/error.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/preprocess.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::benchmark {

/// Time of one piece of work.
struct Cost {
  double wall_ms{0};
  double cpu_ms{0};  ///< of the whole process, all threads
};

/// Both clocks since construction or the last lap().
class CostWatch {
 public:
  [[nodiscard]] Cost lap() {
    const Cost cost{wall_.milliseconds(), 1e3 * (process_cpu_seconds() - cpu_start_s_)};
    wall_.restart();
    cpu_start_s_ = process_cpu_seconds();
    return cost;
  }

 private:
  Stopwatch wall_;
  double cpu_start_s_{process_cpu_seconds()};
};

/// The processing steps of one image.
struct ChainCosts {
  Cost prepare;  ///< wrapping the message, resizing, normalising
  Cost inference;
  Cost decode;  ///< decoding and suppression
  Cost depth;   ///< depth of all boxes, and both result messages
  std::size_t boxes{0};
};

/// What the two nodelets do with an image, called straight in one thread: no topics, queues or workers.
class CoreChain {
 public:
  CoreChain(detect::ModelSpec spec, std::unique_ptr<detect::InferenceBackend> backend,
            sensor_msgs::CameraInfo info);

  [[nodiscard]] Result<ChainCosts> run(const sensor_msgs::ImageConstPtr& color,
                                       const sensor_msgs::ImageConstPtr& depth);

  /// The network alone, on the image of the last run().
  [[nodiscard]] Result<Cost> infer();

  [[nodiscard]] std::string execution() const { return backend_->name() + " on " + backend_->execution(); }

 private:
  [[nodiscard]] Result<detect::Placement> prepare(const sensor_msgs::ImageConstPtr& color);
  [[nodiscard]] Detections decode(const std::vector<detect::TensorView>& tensors,
                                  const detect::Placement& placement) const;
  [[nodiscard]] Result<void> locate(const Detections& detections,
                                    const sensor_msgs::ImageConstPtr& depth) const;

  detect::ModelSpec spec_;
  std::unique_ptr<detect::InferenceBackend> backend_;
  detect::Preprocessor preprocessor_;
  sensor_msgs::CameraInfo info_;
};

}  // namespace extperfc::benchmark
