#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "extperfc/base/error.hpp"
#include "extperfc/face/face_detector.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::face {

inline constexpr int kAlignedSize = 112;  ///< width and height of an aligned face [px]

/// Where the landmarks lie in an aligned face [px], as ArcFace and the networks after it expect them (Deng et
/// al. 2019).
[[nodiscard]] const Landmarks& reference_landmarks();

/// A face, upright and in its place: kAlignedSize x kAlignedSize pixels, BGR, 8 bits, row after row.
struct AlignedFace {
  std::vector<std::uint8_t> bgr;

  /// Valid as long as this face.
  [[nodiscard]] ImageView view() const;
};

/// The similarity (rotation, one positive scale, translation) with the least sum of squared distances from
/// the transformed `from` to `to` (Umeyama 1991, eq. 40 to 42, in the plane and without mirror images). Empty
/// when the points of `from` coincide or a value is not finite.
[[nodiscard]] std::optional<Eigen::Affine2d> fit_similarity(const Landmarks& from, const Landmarks& to);

/// Cuts faces out of one image, which is converted once, bilinear; black where the image ends. A face is
/// empty when its landmarks coincide. Errors: kInvalidArgument for an empty image, kUnsupported for a depth
/// image.
[[nodiscard]] Result<std::vector<std::optional<AlignedFace>>> align(const ImageView& image,
                                                                    const std::vector<Landmarks>& faces);

}  // namespace extperfc::face
