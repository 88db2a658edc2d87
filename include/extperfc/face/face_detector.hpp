#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/preprocess.hpp"
#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::face {

/// Points of a face in image pixels, in the coordinates of Box2: eye and eye, nose, corner and corner of the
/// mouth. Of two, the one that is left in the image of an upright face comes first.
using Landmarks = std::array<Eigen::Vector2f, 5>;

struct DetectedFace {
  Box2 box;             ///< image pixels, clipped to the image
  Landmarks landmarks;  ///< image pixels, may lie outside the image
  float score{0};       ///< [0, 1]
};

/// Image in, faces out: a YuNet (see detect/yunet.hpp) with its pre- and post-processing.
class FaceDetector {
 public:
  /// Loads the network and runs it once. Errors: kInvalidArgument for a layout other than `yunet`, and those
  /// of detect::make_backend().
  [[nodiscard]] static Result<FaceDetector> create(detect::ModelSpec spec,
                                                   const detect::InferenceOptions& options);

  /// Best first. One thread at a time. Errors: those of detect::Preprocessor and of the back end.
  [[nodiscard]] Result<std::vector<DetectedFace>> detect(const ImageView& image);

  [[nodiscard]] const detect::ModelSpec& spec() const { return spec_; }
  /// For the next detect().
  void set_thresholds(const detect::Thresholds& thresholds) { spec_.thresholds = thresholds; }
  /// Back end and what really executes, for logs and diagnostics.
  [[nodiscard]] std::string execution() const { return backend_->name() + " on " + backend_->execution(); }

 private:
  FaceDetector(detect::ModelSpec spec, std::unique_ptr<detect::InferenceBackend> backend);

  detect::ModelSpec spec_;
  std::unique_ptr<detect::InferenceBackend> backend_;
  detect::Preprocessor preprocessor_;
};

/// Greedy non-maximum suppression: best first, without those that overlap a better one by more than
/// `nms_iou`, at most `max_detections`. Looks at the best 1000 faces. Not finite scores must have been left
/// out.
[[nodiscard]] std::vector<DetectedFace> suppress(std::vector<DetectedFace> faces,
                                                 const detect::Thresholds& thresholds);

}  // namespace extperfc::face
