#pragma once

#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/model_spec.hpp"

#include "test/benchmark/detect/footage.hpp"
#include "test/benchmark/detect/nodelet_path.hpp"

namespace extperfc::benchmark {

/// One model on one back end.
struct DetectCase {
  detect::ModelSpec spec;
  NodeletPath::Settings settings;

  [[nodiscard]] std::string name() const;  ///< "fastestdet openvino 1 thread"
};

/// Medians over all frames of a case; wall and CPU time each on its own.
struct DetectFigures {
  Cost bare;     ///< the network alone
  Cost path;     ///< through the nodelets
  Cost prepare;  ///< parts of the core alone
  Cost inference;
  Cost decode;
  Cost depth;
  double path_p95_ms{0};  ///< wall
  double bare_undisturbed_ms{
      0};  ///< 10 % quantile of wall time: what others on the machine took away is small there
  double path_undisturbed_ms{0};
  double mean_boxes{0};
  double mean_objects{0};
  std::string execution;

  /// What the path costs beyond the core's parts: topics, queues and threads.
  [[nodiscard]] Cost transport() const;
};

/// Nodelets, inference alone and the core alone alternate every ten frames, so that all see the same machine.
/// Before every frame comes the same short pause, as between the images of a camera: a process that
/// computes without pause loses the processor to others more often. `number` makes the namespace unique in
/// this process.
[[nodiscard]] Result<DetectFigures> measure(const DetectCase& what, const Footage& footage, int frames,
                                            int number);

}  // namespace extperfc::benchmark
