#pragma once

#include <string>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/model_spec.hpp"

#include "detect/nodelet_path.hpp"
#include "detect/pictures.hpp"

namespace extperfc::benchmark {

/// One model on one back end.
struct DetectCase {
  detect::ModelSpec spec;
  NodeletPath::Settings settings;

  [[nodiscard]] std::string name() const;  ///< "fastestdet openvino 1 thread"
};

/// Medians over all frames of a case [ms].
struct DetectFigures {
  double bare_wall_ms{0};
  double bare_cpu_ms{0};
  double path_wall_ms{0};
  double path_p95_ms{0};
  double path_cpu_ms{0};
  double core_wall_ms{0};  ///< the chain without nodelets
  double core_cpu_ms{0};
  double preprocess_ms{0};
  double inference_ms{0};  ///< inside the chain
  double decode_ms{0};
  double depth_ms{0};
  double mean_boxes{0};
  double mean_objects{0};
  std::string execution;
};

/// Nodelets, inference alone and the core alone take turns of ten frames, so that all see the same machine.
/// `number` makes the namespace unique in this process.
[[nodiscard]] Result<DetectFigures> measure(const DetectCase& what, const Footage& footage, int frames,
                                            int number);

}  // namespace extperfc::benchmark
