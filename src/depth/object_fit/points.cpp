#include "depth/object_fit/points.hpp"

#include <algorithm>
#include <cmath>

#include "depth/depth_pixel.hpp"

namespace extperfc::depth {
namespace {

constexpr double kMaxPixels = 4000;
constexpr double kRounding = 0.001 / 3.4641016151377544;  // sigma of rounding to 1 mm [m]: 1 mm / sqrt(12)
constexpr double kBoxGrowth =
    0.05;                       // detections are tight or a little too small: fraction of the box's sides
constexpr double kReach = 2.0;  // of what belongs to the object's surroundings, in diagonals of the box

/// Pixels [begin, end) of one axis.
struct Range {
  int begin, end;
  [[nodiscard]] int length() const { return std::max(0, end - begin); }
};

Range range_of(double low, double high, double more, int size) {
  return {static_cast<int>(std::floor(std::clamp(low - more, 0.0, static_cast<double>(size)))),
          static_cast<int>(std::ceil(std::clamp(high + more, 0.0, static_cast<double>(size))))};
}

bool inside(const Box2& box, int x, int y) {
  const double grow_x = kBoxGrowth * box.width();
  const double grow_y = kBoxGrowth * box.height();
  return x + 0.5 > box.x_min - grow_x && x + 0.5 < box.x_max + grow_x && y + 0.5 > box.y_min - grow_y &&
         y + 0.5 < box.y_max + grow_y;
}

}  // namespace

Point point_at(const CameraModel& camera, int x, int y, double z_m, const StereoNoiseModel& noise) {
  const Eigen::Vector3d position = camera.back_project(x, y, z_m);
  const double along_ray = position.norm() / z_m;
  return {position, along_ray * std::hypot(noise.sigma(z_m), kRounding), false};
}

Points gather(const ImageView& depth, const CameraModel& camera, const Box2& box,
              const Eigen::Vector3d& anchor, const ObjectFitParams& params) {
  const double side = std::max(box.width(), box.height());
  const Range columns = range_of(box.x_min, box.x_max, params.surround * side, depth.width);
  const Range rows = range_of(box.y_min, box.y_max, params.surround * side, depth.height);
  const double pixels = static_cast<double>(columns.length()) * rows.length();
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMaxPixels))));
  const double reach = kReach * std::hypot(box.width() / camera.fx, box.height() / camera.fy) * anchor.z();
  Points points;
  const double patch = params.noise.correlation_px * params.noise.correlation_px;
  points.independent = std::min(1.0, static_cast<double>(step) * step / patch);
  for (int y = rows.begin + step / 2; y < rows.end; y += step)
    for (int x = columns.begin + step / 2; x < columns.end; x += step) {
      const double z = depth_at(depth, x, y);
      if (!(z >= params.min_depth_m && z <= params.max_depth_m)) continue;
      Point point = point_at(camera, x, y, z, params.noise);
      if ((point.position - anchor).norm() > reach) continue;
      point.in_box = inside(box, x, y);
      points.items.push_back(point);
    }
  return points;
}

}  // namespace extperfc::depth
