#include "scan/silent_beams.hpp"

#include <cmath>

namespace extperfc::scan {

namespace {

/// Finds the point of a ring and a firing in either order of rows.
struct Grid {
  std::size_t rings, firings, ring_step, firing_step;
  [[nodiscard]] std::size_t index(std::size_t ring, std::size_t firing) const {
    return ring * ring_step + firing * firing_step;
  }
};

Grid grid_of(const CloudView& cloud) {
  if (cloud.height <= cloud.width) return {cloud.height, cloud.width, cloud.width, 1};
  return {cloud.width, cloud.height, 1, cloud.width};
}

Eigen::Vector3f at(const CloudPoints& points, std::size_t i) {
  return {points.sensor_x[i], points.sensor_y[i], points.sensor_z[i]};
}

bool is_return(const Eigen::Vector3f& point) {
  return point.squaredNorm() > 0;  // false for NaN
}

/// Mean elevation of every ring [rad]; NaN for a ring without a return.
std::vector<float> elevations(const Grid& grid, const CloudPoints& points) {
  std::vector<float> result(grid.rings);
  for (std::size_t ring = 0; ring < grid.rings; ++ring) {
    float sum = 0;
    float count = 0;
    for (std::size_t firing = 0; firing < grid.firings; ++firing) {
      const Eigen::Vector3f point = at(points, grid.index(ring, firing));
      if (!is_return(point)) continue;
      sum += std::atan2(point.z(), point.head<2>().norm());
      ++count;
    }
    result[ring] = sum / count;
  }
  return result;
}

/// Adds the silent beams of one firing; none where no beam of it has an azimuth.
void add_firing(const Grid& grid, std::size_t firing, const std::vector<float>& elevation,
                const CloudPoints& points, std::vector<SilentBeam>& beams) {
  std::size_t known = 0;
  while (known < grid.rings && !is_return(at(points, grid.index(known, firing)))) ++known;
  if (known == grid.rings) return;
  const std::size_t neighbour = grid.index(known, firing);
  const Eigen::Vector2f heading = at(points, neighbour).head<2>().normalized();
  for (std::size_t ring = 0; ring < grid.rings; ++ring) {
    if (std::isnan(elevation[ring]) || is_return(at(points, grid.index(ring, firing)))) continue;
    const float level = std::cos(elevation[ring]);
    beams.push_back({{level * heading.x(), level * heading.y(), std::sin(elevation[ring])},
                     points.time_s.empty() ? 0.0F : points.time_s[neighbour]});
  }
}

}  // namespace

void silent_beams(const CloudView& cloud, const CloudPoints& points, std::vector<SilentBeam>& beams) {
  beams.clear();
  if (cloud.height < 2 || cloud.width < 2 || points.size() != cloud.size()) return;
  const Grid grid = grid_of(cloud);
  const auto elevation = elevations(grid, points);
  for (std::size_t firing = 0; firing < grid.firings; ++firing)
    add_firing(grid, firing, elevation, points, beams);
}

}  // namespace extperfc::scan
