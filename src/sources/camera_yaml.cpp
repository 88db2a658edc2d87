#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "extperfc/sources/recording.hpp"
#include "extperfc/world/yaml_map.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxSize = 100000;  // pixels

void read_distortion(YamlMap& file, CameraModel& camera) {
  const std::string model = file.text("distortion_model", "plumb_bob");
  if (!file.has("distortion_coefficients")) return;
  const auto d = file.section("distortion_coefficients").numbers("data", {0, kAnyNumber}, kFinite);
  const std::size_t known = std::min(d.size(), camera.distortion.size());
  std::copy_n(d.begin(), known, camera.distortion.begin());
  const auto is_zero = [](double k) { return k == 0.0; };
  const bool more = !std::all_of(d.begin() + static_cast<std::ptrdiff_t>(known), d.end(), is_zero);
  if (!std::all_of(d.begin(), d.end(), is_zero) && (model != "plumb_bob" || more))
    file.problem("distortion_model",
                 "'" + model + "' with " + std::to_string(d.size()) +
                     " coefficients is not supported: only plumb_bob with five is",
                 ErrorCode::kUnsupported);
}

CameraModel read_camera(YamlMap& file) {
  CameraModel camera;
  camera.width = file.integer("image_width", 1, kMaxSize);
  camera.height = file.integer("image_height", 1, kMaxSize);
  const auto k = file.section("camera_matrix", true).numbers("data", 9, kFinite);
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
  read_distortion(file, camera);
  return camera;
}

}  // namespace

Result<CameraModel> load_camera_yaml(const fs::path& file) {
  Problems problems(file.string(), ErrorCode::kCorrupt);
  const auto root = load_yaml(file, problems);
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap map(*root, "", problems);
  const CameraModel camera = read_camera(map);
  if (problems.empty())
    if (const auto valid = camera.validate(); !valid)
      problems.add(0, "", valid.error().message, valid.error().code);
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return camera;
}

}  // namespace extperfc::sources
