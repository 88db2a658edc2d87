#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <system_error>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "extperfc/sources/recording.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

/// Values of a matrix node {rows, cols, data: [...]}. Throws YAML::Exception.
std::vector<double> matrix(const YAML::Node& root, const char* key) {
  return root[key]["data"].as<std::vector<double>>();
}

Result<CameraModel> with_distortion(CameraModel camera, const YAML::Node& root) {
  const auto model = root["distortion_model"].as<std::string>("plumb_bob");
  const auto d =
      root["distortion_coefficients"] ? matrix(root, "distortion_coefficients") : std::vector<double>{};
  const std::size_t known = std::min(d.size(), camera.distortion.size());
  std::copy_n(d.begin(), known, camera.distortion.begin());
  const bool more =
      std::any_of(d.begin() + static_cast<std::ptrdiff_t>(known), d.end(), [](double k) { return k != 0.0; });
  const bool none = std::all_of(d.begin(), d.end(), [](double k) { return k == 0.0; });
  if (!none && (model != "plumb_bob" || more))
    return fail(ErrorCode::kUnsupported, "distortion model '" + model + "' with " + std::to_string(d.size()) +
                                             " coefficients; only plumb_bob with five is supported");
  return camera;
}

Result<CameraModel> parse(const YAML::Node& root) {
  CameraModel camera;
  camera.width = root["image_width"].as<int>();
  camera.height = root["image_height"].as<int>();
  const auto k = matrix(root, "camera_matrix");
  if (k.size() != 9)
    return fail(ErrorCode::kCorrupt,
                "camera_matrix has " + std::to_string(k.size()) + " values instead of 9");
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
  return with_distortion(camera, root);
}

}  // namespace

Result<CameraModel> load_camera_yaml(const fs::path& file) {
  const auto in_file = [&file](const Error& e) { return Error{e.code, file.string() + ": " + e.message}; };
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored))
    return fail(ErrorCode::kNotFound, "no camera file " + file.string());
  try {
    auto camera = parse(YAML::LoadFile(file.string()));
    if (!camera) return tl::unexpected(in_file(camera.error()));
    if (const auto valid = camera->validate(); !valid) return tl::unexpected(in_file(valid.error()));
    return camera;
  } catch (const YAML::Exception& e) {
    return fail(
        ErrorCode::kCorrupt,
        file.string() +
            ": not a camera_calibration file (needs image_width, image_height, camera_matrix): " + e.what());
  }
}

}  // namespace extperfc::sources
