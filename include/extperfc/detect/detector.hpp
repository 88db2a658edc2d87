#pragma once

#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"
#include "extperfc/detect/preprocess.hpp"
#include "extperfc/world/class_filter.hpp"
#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::detect {

/// Wall time of the parts of one detection [ms].
struct StageTimes {
  double preprocess_ms{0};
  double inference_ms{0};
  double decode_ms{0};
};

struct DetectorOutput {
  Detections detections;  ///< best first, boxes in pixels of the image, clipped to it
  StageTimes times;
};

/// Which candidates of a network are detections.
struct Selection {
  Thresholds thresholds;
  ClassFilter classes;
};

/// A model with its pre- and post-processing: image in, boxes out.
class Detector {
 public:
  /// Loads the model and runs it once on a grey image; see make_backend() for the errors.
  [[nodiscard]] static Result<Detector> create(ModelSpec spec, const InferenceOptions& options);

  /// One image, `slot` in [0, slots()). Different slots may be used by different threads at the same time.
  [[nodiscard]] Result<DetectorOutput> detect(const ImageView& image, int slot = 0);
  /// The same with other thresholds than the model's, and for some classes alone.
  [[nodiscard]] Result<DetectorOutput> detect(const ImageView& image, const Selection& selection,
                                              int slot = 0);

  [[nodiscard]] const ModelSpec& spec() const { return spec_; }
  [[nodiscard]] int slots() const { return backend_->slots(); }
  /// Back end and what really executes, for logs and diagnostics.
  [[nodiscard]] std::string execution() const { return backend_->name() + " on " + backend_->execution(); }
  /// The back end alone, for benchmarks of bare inference.
  [[nodiscard]] InferenceBackend& backend() { return *backend_; }

 private:
  Detector(ModelSpec spec, std::unique_ptr<InferenceBackend> backend);

  ModelSpec spec_;
  std::unique_ptr<InferenceBackend> backend_;
  std::vector<Preprocessor> preprocessors_;  // one per slot
  std::vector<ModelSpec> selected_;          // one per slot: the model with the thresholds of its last call
};

}  // namespace extperfc::detect
