#include "test/benchmark/depth/cases.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include "extperfc/base/math.hpp"

namespace extperfc::benchmark {

namespace {
constexpr double kMinSize = 0.06;     // of objects [m]
constexpr double kMaxSize = 0.20;     // [m]
constexpr double kMaxSizePx = 330.0;  // larger objects do not fit the image
constexpr float kMinBoxPx = 8.0F;     // smaller boxes are not detected

struct Range {
  const char* name;
  double near_m;
  double far_m;
};

constexpr Range kRanges[] = {{"0.2-0.9 m", 0.2, 0.9}, {"0.9-2.0 m", 0.9, 2.0}, {"2.0-3.5 m", 2.0, 3.5}};

/// Unit normal of the floor for a camera that looks `pitch` down and is rolled a little.
Eigen::Vector3d floor_normal(double pitch, double roll) {
  return Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
         Eigen::Vector3d(0.0, -std::cos(pitch), -std::sin(pitch));
}

/// Horizontal unit vector towards the camera, turned by `yaw`.
Eigen::Vector3d wall_normal(const Eigen::Vector3d& up, double yaw) {
  const Eigen::Vector3d back(0, 0, -1);
  const Eigen::Vector3d level = (back - back.dot(up) * up).normalized();
  return Eigen::AngleAxisd(yaw, up) * level;
}

/// Pixel where the middle of the object goes.
Eigen::Vector2d draw_pixel(const Case& kind, const CameraModel& camera, double size_px, Rng& rng) {
  if (!kind.at_border) {
    const double edge = std::min(0.6 * size_px, 0.45 * camera.height);
    return {rng.uniform(edge, camera.width - edge), rng.uniform(edge, camera.height - edge)};
  }
  const double inwards = rng.uniform(-0.25, 0.25) * size_px;  // a part of the object stays outside
  const int side = rng.integer(0, 2);
  if (side == 0) return {inwards, rng.uniform(0.3, 0.7) * camera.height};
  if (side == 1) return {camera.width - inwards, rng.uniform(0.3, 0.7) * camera.height};
  return {rng.uniform(0.2, 0.8) * camera.width, camera.height - inwards};
}

Scene draw_scene(const Case& kind, const CameraModel& camera, Rng& rng) {
  Scene scene;
  const auto shape = rng.integer(0, static_cast<int>(kind.shapes.size()) - 1);
  scene.shape = kind.shapes[static_cast<std::size_t>(shape)];
  const double z = rng.uniform(kind.near_m, kind.far_m + 0.1);
  scene.size_m = rng.uniform(kMinSize, std::max(kMinSize, std::min(kMaxSize, kMaxSizePx * z / camera.fx)));
  scene.cone_radius_m = rng.uniform(0.25, 0.45) * scene.size_m;
  scene.yaw_rad = rng.uniform(-kPi, kPi);
  scene.up = floor_normal(rng.uniform(0.2, 0.9), rng.normal(0.0, 0.03));
  scene.wall = wall_normal(scene.up, rng.uniform(-0.5, 0.5));
  scene.wall_distance_m = rng.uniform(0.15, 1.5);
  const auto pixel = draw_pixel(kind, camera, camera.fx * scene.size_m / z, rng);
  scene.base = camera.back_project(pixel.x(), pixel.y(), z) - 0.5 * scene.size_m * scene.up;
  return scene;
}

bool fits(const Case& kind, const Rendering& r, const CameraModel& camera) {
  const Box2& box = r.box;
  const bool visible = box.width() >= kMinBoxPx && box.height() >= kMinBoxPx;
  const bool in_range = r.truth_m >= kind.near_m && r.truth_m <= kind.far_m;
  const bool cut = box.x_min <= 0.0F || box.y_min <= 0.0F || box.x_max >= static_cast<float>(camera.width) ||
                   box.y_max >= static_cast<float>(camera.height);
  return visible && in_range && cut == kind.at_border;
}

}  // namespace

std::vector<Case> all_cases() {
  const std::vector<Shape> every{Shape::kCone, Shape::kCube, Shape::kSphere};
  std::vector<Case> cases;
  for (const auto& range : kRanges) {
    cases.push_back({std::string("cone ") + range.name, {Shape::kCone}, range.near_m, range.far_m});
    cases.push_back({std::string("cube ") + range.name, {Shape::kCube}, range.near_m, range.far_m});
    cases.push_back({std::string("sphere ") + range.name, {Shape::kSphere}, range.near_m, range.far_m});
  }
  cases.push_back({"image border", every, 0.2, 3.5, true});
  cases.push_back({"bad boxes", every, 0.2, 3.5, false, {0.12, 0.15, 1.1}});
  return cases;
}

Rendering draw_rendering(const Case& kind, const CameraModel& camera, Rng& rng) {
  for (;;) {
    Rendering rendering = render(draw_scene(kind, camera, rng), camera);
    if (fits(kind, rendering, camera)) return rendering;
  }
}

Box2 detected_box(const Box2& box, const BoxError& error, const CameraModel& camera, Rng& rng) {
  const auto side = [&](float low, float high, int limit, float& out_low, float& out_high) {
    const double length = high - low;
    const double center = 0.5 * (low + high) + rng.normal(0.0, error.shift * length);
    const double half = 0.5 * length * std::max(0.4, rng.normal(error.mean_scale, error.scale));
    out_low = static_cast<float>(std::clamp(center - half, 0.0, limit - 1.0));
    out_high = static_cast<float>(std::clamp(center + half, out_low + 1.0, static_cast<double>(limit)));
  };
  Box2 found;
  side(box.x_min, box.x_max, camera.width, found.x_min, found.x_max);
  side(box.y_min, box.y_max, camera.height, found.y_min, found.y_max);
  return found;
}

}  // namespace extperfc::benchmark
