#pragma once

#include <filesystem>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "extperfc/base/error.hpp"
#include "extperfc/world/camera_model.hpp"

namespace extperfc::benchmark {

/// Aligned images of one moment, of the same size.
struct ImagePair {
  cv::Mat color;  ///< CV_8UC3, BGR
  cv::Mat depth;  ///< CV_16UC1 [mm]
};

/// What a camera delivers, again and again in this order.
struct Footage {
  std::vector<ImagePair> images;  ///< at least one
  CameraModel camera;
};

/// All complete pairs of `folder`, see sources::open_pair_folder().
[[nodiscard]] Result<Footage> load_footage(const std::filesystem::path& folder);

/// One drawn image, 640 x 480: a cone, a cube and two spheres before a wall, with depth.
[[nodiscard]] Footage draw_footage();

}  // namespace extperfc::benchmark
