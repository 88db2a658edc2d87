#include "extperfc/scan/cloud_to_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "scan/cloud_points.hpp"
#include "scan/columns.hpp"
#include "scan/find_ground.hpp"
#include "scan/ray_layout.hpp"
#include "scan/silent_beams.hpp"
#include "scan/slope_ground.hpp"
#include "scan/support.hpp"
#include "scan/sweep_transform.hpp"

namespace extperfc::scan {

namespace {

Ground level_ground(const GroundParams& params) {
  Ground ground;
  ground.offset = static_cast<float>(-params.z_m);
  return ground;
}

}  // namespace

class CloudToScan::Impl {
 public:
  explicit Impl(const ScanParams& params) : params_(params), layout_(params) {}

  Result<ScanStatistics> convert(const CloudView& cloud, const SensorTrack& track, const SelfFilter& robot,
                                 PlanarScans& scans);
  [[nodiscard]] std::size_t rays() const { return layout_.count(); }

 private:
  Result<void> check(const CloudView& cloud, const SensorTrack& track) const;
  void read(const CloudView& cloud, const SweepTransform& transform, ScanStatistics& statistics);
  void choose_ground(ScanStatistics& statistics) const;
  void sort_points(const SelfFilter& robot, const Eigen::Vector3f& origin, ScanStatistics& statistics);
  void see_silent_beams(const CloudView& cloud, const SweepTransform& transform,
                        const Eigen::Vector3f& origin, const Ground& ground);
  void see_through(const Eigen::Vector3f& origin, const Eigen::Vector3f& far, const Ground& ground);
  void follow_slopes(ScanStatistics& statistics);
  void fill_ray(std::size_t ray, PlanarScans& scans, ScanStatistics& statistics);
  [[nodiscard]] bool reads_intensity() const {
    return params_.intensity == IntensityOf::kNearest || params_.intensity == IntensityOf::kMaximum;
  }
  [[nodiscard]] float height_of(std::size_t ray, float range);
  void set(std::size_t ray, float range, std::uint32_t point, PlanarScan& scan);

  ScanParams params_;
  RayLayout layout_;
  CloudPoints points_;
  std::vector<std::uint32_t> rays_;  ///< of every point, see RayLayout
  Columns columns_;
  std::vector<SilentBeam> silent_;
  std::vector<char> free_;  ///< rays along which a beam went on beyond range_max
  float lidar_height_{0};
};

Result<void> CloudToScan::Impl::check(const CloudView& cloud, const SensorTrack& track) const {
  if (auto valid = validate(cloud); !valid) return valid;
  if (track.empty()) return fail(ErrorCode::kInvalidArgument, "the sensor's track has no pose");
  if (params_.rings && !cloud.ring && cloud.size() > 0)
    return fail(ErrorCode::kNotFound,
                "rings are selected, but the cloud has no field 'ring'; leave the parameter rings empty");
  return {};
}

Result<ScanStatistics> CloudToScan::Impl::convert(const CloudView& cloud, const SensorTrack& track,
                                                  const SelfFilter& robot, PlanarScans& scans) {
  if (auto usable = check(cloud, track); !usable) return tl::unexpected(usable.error());
  ScanStatistics statistics;
  statistics.points = cloud.size();
  const bool heights = params_.intensity == IntensityOf::kHeight;
  statistics.intensity_missing = reads_intensity() && !cloud.intensity && statistics.points > 0;
  statistics.ground = level_ground(params_.ground);
  for (auto* scan : {&scans.supported, &scans.nearest})
    layout_.clear(*scan, heights || (reads_intensity() && cloud.intensity));
  columns_.clear(layout_.count(), cloud.size());
  free_.assign(layout_.count(), 0);
  if (statistics.points > 0) {
    const SweepTransform transform(track);
    const Eigen::Vector3f origin = transform.map(0, Eigen::Vector3f::Zero());
    read(cloud, transform, statistics);
    choose_ground(statistics);
    lidar_height_ = origin.z();
    sort_points(robot, origin, statistics);
    see_silent_beams(cloud, transform, origin, statistics.ground);
  }
  columns_.sort();
  follow_slopes(statistics);
  for (std::size_t ray = 0; ray < layout_.count(); ++ray) fill_ray(ray, scans, statistics);
  return statistics;
}

void CloudToScan::Impl::read(const CloudView& cloud, const SweepTransform& transform,
                             ScanStatistics& statistics) {
  ReadOptions options;
  options.rings = params_.rings ? &*params_.rings : nullptr;
  options.intensity = reads_intensity();
  options.time = transform.moves();
  options.azimuth_times = params_.azimuth_times;
  options.revolution_s = params_.scan_time;
  read_points(cloud, options, points_);
  transform.apply(points_);
  statistics.deskewed = !points_.time_s.empty();
}

void CloudToScan::Impl::choose_ground(ScanStatistics& statistics) const {
  if (params_.ground.method != GroundMethod::kPlane) return;
  const auto found = find_ground(points_, params_.ground);
  statistics.ground_found = found.has_value();
  if (found) statistics.ground = *found;
}

void CloudToScan::Impl::sort_points(const SelfFilter& robot, const Eigen::Vector3f& origin,
                                    ScanStatistics& statistics) {
  const bool by_slope = params_.ground.method == GroundMethod::kSlope;
  // The floor below the height band leads to the floor within it.
  const auto lowest = by_slope ? -std::numeric_limits<float>::max() : static_cast<float>(params_.min_height);
  const auto highest = static_cast<float>(params_.max_height);
  const auto nearest = static_cast<float>(params_.range_min * params_.range_min);
  const auto farthest = static_cast<float>(params_.range_max * params_.range_max);
  const bool has_ground = !by_slope && params_.ground.method != GroundMethod::kNone;
  const auto clearance = static_cast<float>(params_.ground.clearance_m);
  layout_.rays_of(points_.x, points_.y, rays_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3f point(points_.x[i], points_.y[i], points_.z[i]);
    const float squared_range = point.x() * point.x() + point.y() * point.y();
    if (squared_range > farthest) see_through(origin, point, statistics.ground);
    // Written so that NaN fails.
    if (!(point.z() >= lowest && point.z() <= highest && squared_range >= nearest &&
          squared_range <= farthest))
      continue;
    if (has_ground && statistics.ground.height(point) < clearance) {
      ++statistics.on_ground;
      continue;
    }
    const std::size_t ray = rays_[i];
    if (ray >= layout_.count()) continue;
    if (robot.contains({points_.sensor_x[i], points_.sensor_y[i], points_.sensor_z[i]})) {
      ++statistics.on_robot;
      continue;
    }
    columns_.add(ray, std::sqrt(squared_range), i);
    ++statistics.used;
  }
}

void CloudToScan::Impl::see_silent_beams(const CloudView& cloud, const SweepTransform& transform,
                                         const Eigen::Vector3f& origin, const Ground& ground) {
  if (params_.rings || !(params_.no_return_range > params_.range_max)) return;
  silent_beams(cloud, points_, silent_);
  const auto length = static_cast<float>(params_.no_return_range);
  for (const SilentBeam& beam : silent_)
    see_through(origin, transform.map(beam.time_s, length * beam.direction), ground);
}

/// Marks the ray on whose circle of range_max the beam from `origin` to `far` passes, when the beam is inside
/// the height band there and at range_min.
void CloudToScan::Impl::see_through(const Eigen::Vector3f& origin, const Eigen::Vector3f& far,
                                    const Ground& ground) {
  const Eigen::Vector3f beam = far - origin;
  const float a = beam.head<2>().squaredNorm();
  const float b = beam.head<2>().dot(origin.head<2>());
  /// Where the beam leaves the circle, as a fraction of it; NaN when it never crosses it.
  const auto leaves = [&](double radius) {
    const float c = origin.head<2>().squaredNorm() - static_cast<float>(radius * radius);
    return (std::sqrt(b * b - a * c) - b) / a;
  };
  const Eigen::Vector3f entry = origin + std::max(0.0F, leaves(params_.range_min)) * beam;
  const float exit_fraction = leaves(params_.range_max);
  const Eigen::Vector3f exit = origin + exit_fraction * beam;
  if (!(exit_fraction <= 1.0F)) return;
  const bool has_ground = params_.ground.method != GroundMethod::kNone;
  const auto clearance =
      has_ground ? static_cast<float>(params_.ground.clearance_m) : -std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& point : {entry, exit})
    if (!(point.z() >= static_cast<float>(params_.min_height) &&
          point.z() <= static_cast<float>(params_.max_height) && ground.height(point) >= clearance))
      return;
  const std::size_t ray = layout_.ray_of(exit.x(), exit.y());
  if (ray < layout_.count()) free_[ray] = 1;
}

void CloudToScan::Impl::follow_slopes(ScanStatistics& statistics) {
  if (params_.ground.method != GroundMethod::kSlope) return;
  const auto lowest = static_cast<float>(params_.min_height);
  std::size_t obstacles = 0;
  for (std::size_t ray = 0; ray < layout_.count(); ++ray) {
    const Column column = columns_.column(ray);
    ColumnPoint* const end = column.first + obstacles_first(column, points_.z, params_.ground);
    statistics.on_ground += static_cast<std::size_t>(column.last - end);
    ColumnPoint* const kept = std::remove_if(
        column.first, end, [&](const ColumnPoint& point) { return points_.z[point.index] < lowest; });
    columns_.shrink(ray, static_cast<std::size_t>(kept - column.first));
    obstacles += static_cast<std::size_t>(kept - column.first);
  }
  statistics.used = obstacles;
}

void CloudToScan::Impl::fill_ray(std::size_t ray, PlanarScans& scans, ScanStatistics& statistics) {
  const float free = params_.use_inf ? std::numeric_limits<float>::infinity()
                                     : static_cast<float>(params_.range_max + params_.inf_epsilon);
  if (free_[ray] != 0) scans.supported.ranges[ray] = scans.nearest.ranges[ray] = free;
  const Column column = columns_.column(ray);
  if (column.empty()) {
    ++(free_[ray] != 0 ? statistics.rays_free : statistics.rays_unknown);
    return;
  }
  ++statistics.rays_met;
  const float nearest = std::min(nearest_range(column, static_cast<float>(params_.range_noise_m)),
                                 static_cast<float>(params_.range_max));
  set(ray, nearest, column.first->index, scans.nearest);
  const auto surface = supported_surface(column, columns_.column(layout_.neighbour(ray, -1)),
                                         columns_.column(layout_.neighbour(ray, 1)), points_.level,
                                         static_cast<float>(params_.support_m));
  if (!surface) return;
  set(ray, surface->range, surface->index, scans.supported);
  if (surface->two_rings) ++statistics.rays_supported;
}

/// Of a wall or a person, which several rings meet, the height nearest to the lidar's: from there it is seen
/// at any distance.
float CloudToScan::Impl::height_of(std::size_t ray, float range) {
  constexpr float kSameSurface = 0.1F;
  float nearest = std::numeric_limits<float>::infinity();
  float height = 0;
  for (const ColumnPoint& point : columns_.column(ray)) {
    if (point.range < range - kSameSurface || point.range > range + kSameSurface) continue;
    const float away = std::abs(points_.z[point.index] - lidar_height_);
    if (away >= nearest) continue;
    nearest = away;
    height = points_.z[point.index];
  }
  return height;
}

void CloudToScan::Impl::set(std::size_t ray, float range, std::uint32_t point, PlanarScan& scan) {
  scan.ranges[ray] = range;
  if (scan.intensities.empty()) return;
  if (params_.intensity == IntensityOf::kHeight) {
    scan.intensities[ray] = height_of(ray, range);
    return;
  }
  float intensity = points_.intensity[point];
  if (params_.intensity == IntensityOf::kMaximum)
    for (const ColumnPoint& other : columns_.column(ray))
      intensity = std::max(intensity, points_.intensity[other.index]);
  scan.intensities[ray] = intensity;
}

Result<CloudToScan> CloudToScan::make(const ScanParams& params) {
  if (auto valid = validate(params); !valid) return tl::unexpected(valid.error());
  return CloudToScan(std::make_unique<Impl>(params));
}

CloudToScan::CloudToScan(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CloudToScan::CloudToScan(CloudToScan&&) noexcept = default;
CloudToScan& CloudToScan::operator=(CloudToScan&&) noexcept = default;
CloudToScan::~CloudToScan() = default;

Result<ScanStatistics> CloudToScan::convert(const CloudView& cloud, const SensorTrack& track,
                                            const SelfFilter& robot, PlanarScans& scans) {
  return impl_->convert(cloud, track, robot, scans);
}

std::size_t CloudToScan::rays() const {
  return impl_->rays();
}

}  // namespace extperfc::scan
