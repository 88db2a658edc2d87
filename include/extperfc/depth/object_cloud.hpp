#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "extperfc/depth/box_depth.hpp"

namespace extperfc::depth {

/// The measured points of one object.
struct ObjectCloud {
  std::vector<Eigen::Vector3f> points;  ///< optical frame [m], row by row of the image
  int background_px{0};                 ///< valid pixels of the box that belong to something else
  int support_px{0};                    ///< of these: pixels of what the object stands on
};

/// Every pixel of the object in `box`, without what lies behind it, before it or beside it.
///
/// 1. Seeds: pixels in the middle of the box that lie in its nearest dense depth layer (as estimate_depth()
///    with nearest_mode).
/// 2. Growth: neighbours (four, also over a hole of one pixel) inside the box join when their depths differ
/// by less than noise and a slanted
///    surface explain, and when they lie no deeper behind the seeds than the box is wide or high.
/// 3. Support: with `up` (unit vector against gravity, optical frame) the plane around the box is looked for,
///    and pixels on it are left out; without `up` the corners of a box may hold a little of the table.
///
/// Errors: kInvalidArgument for an image that is no depth or a box without area; kNotFound when fewer than
/// params.min_valid_px pixels are left. `depth` is aligned to the image of `box`. Time: proportional to the
/// pixels of the box. Preconditions: validate(params) and camera.validate() passed. Thread-safe.
[[nodiscard]] Result<ObjectCloud> object_cloud(const ImageView& depth, const CameraModel& camera,
                                               const Box2& box, const BoxDepthParams& params,
                                               const std::optional<Eigen::Vector3d>& up = std::nullopt);

}  // namespace extperfc::depth
