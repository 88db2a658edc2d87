#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "extperfc/detect/inference.hpp"
#include "extperfc/detect/model_spec.hpp"
#include "extperfc/world/detection.hpp"

namespace extperfc::detect {

/// A face with its landmarks: the eye, the nose, the corner of the mouth that are left in the image come
/// before those that are right: eye, eye, nose, corner, corner.
struct YunetCandidate {
  Detection detection;                       ///< class 0, box in input pixels
  std::array<Eigen::Vector2f, 5> landmarks;  ///< input pixels
};

/// Candidates at or above the score threshold, before suppression, of YuNet (Wu et al. 2023, "YuNet: A Tiny
/// Millisecond-level Face Detector"). The outputs are cls, obj, bbox and kps, each of the strides 8, 16 and
/// 32; one row of 1, 1, 4 and 10 numbers for each cell, row after row of cells. For the cell (column, row):
///   score = sqrt(cls * obj), both limited to [0, 1]
///   centre = ((column, row) + bbox[0..1]) * stride, size = exp(bbox[2..3]) * stride
///   landmark i = ((column, row) + kps[2 i .. 2 i + 1]) * stride
/// The shapes must have passed check_outputs(). Candidates with a value that is not finite are left out.
[[nodiscard]] std::vector<YunetCandidate> decode_yunet(const ModelSpec& spec,
                                                       const std::vector<TensorView>& outputs);

}  // namespace extperfc::detect
