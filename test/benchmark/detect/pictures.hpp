#pragma once

#include <filesystem>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"

namespace extperfc::benchmark {

/// Aligned pictures of one moment, of the same size.
struct Picture {
  cv::Mat color;  ///< CV_8UC3, BGR
  cv::Mat depth;  ///< CV_16UC1 [mm]
};

/// What a camera delivers, again and again in this order.
struct Footage {
  std::vector<Picture> pictures;  ///< at least one
  CameraModel camera;
};

/// All complete pairs of `folder`, see sources::open_pair_folder().
[[nodiscard]] Result<Footage> load_footage(const std::filesystem::path& folder);

/// One drawn picture, 640 x 480: a cone, a cube and two spheres before a wall, with depth.
[[nodiscard]] Footage draw_footage();

}  // namespace extperfc::benchmark
