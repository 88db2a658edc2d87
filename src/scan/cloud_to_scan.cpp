#include "extperfc/scan/cloud_to_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scan/cloud_points.hpp"
#include "scan/find_ground.hpp"

namespace extperfc::scan {

namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;
constexpr float kNothing = std::numeric_limits<float>::infinity();

/// A turn that is complete: the ray after the last one would be the first again.
bool is_full_turn(const ScanParams& params, double rays) {
  constexpr double kRoundingRad = 1e-6;
  return rays * params.angle_increment > kTurn - kRoundingRad;
}

/// Rays at angle_min + i * increment up to angle_max.
std::size_t count_rays(const ScanParams& params) {
  constexpr double kRounding = 1e-3;  // of an increment: angles come from text with few digits
  const double steps = std::floor((params.angle_max - params.angle_min) / params.angle_increment + kRounding);
  return static_cast<std::size_t>(is_full_turn(params, steps) ? steps : steps + 1);
}

Ground level_ground(const GroundParams& params) {
  Ground ground;
  ground.offset = static_cast<float>(-params.z_m);
  return ground;
}

}  // namespace

class CloudToScan::Impl {
 public:
  explicit Impl(const ScanParams& params)
      : params_(params),
        rays_(count_rays(params)),
        full_turn_(is_full_turn(params, static_cast<double>(rays_))),
        rays_per_rad_(static_cast<float>(1.0 / params.angle_increment)),
        first_edge_rad_(static_cast<float>(params.angle_min - 0.5 * params.angle_increment)) {}

  Result<ScanStatistics> convert(const CloudView& cloud, const Pose& target_T_cloud, PlanarScan& scan);
  [[nodiscard]] std::size_t rays() const { return rays_; }

 private:
  void clear(PlanarScan& scan, bool with_intensity) const;
  void choose_ground(ScanStatistics& statistics) const;
  void fill(PlanarScan& scan, ScanStatistics& statistics) const;
  void add(std::size_t point, std::size_t ray, float squared_range, PlanarScan& scan) const;
  void finish(PlanarScan& scan) const;
  [[nodiscard]] std::size_t ray_of(float x, float y) const;

  ScanParams params_;
  std::size_t rays_;
  bool full_turn_;
  float rays_per_rad_;
  float first_edge_rad_;  ///< lower edge of the first ray's bin
  CloudPoints points_;
};

Result<ScanStatistics> CloudToScan::Impl::convert(const CloudView& cloud, const Pose& target_T_cloud,
                                                  PlanarScan& scan) {
  if (auto valid = validate(cloud); !valid) return tl::unexpected(valid.error());
  ScanStatistics statistics;
  statistics.points = cloud.size();
  const bool wants_intensity = params_.intensity != IntensityOf::kNone;
  const bool with_intensity = wants_intensity && cloud.intensity;
  statistics.intensity_missing = wants_intensity && !with_intensity && statistics.points > 0;
  statistics.ground = level_ground(params_.ground);
  clear(scan, with_intensity);
  if (statistics.points > 0) {
    if (params_.rings && !cloud.ring)
      return fail(ErrorCode::kNotFound,
                  "rings are selected, but the cloud has no field 'ring'; leave the parameter rings empty");
    read_points(cloud, target_T_cloud, {params_.rings ? &*params_.rings : nullptr, with_intensity}, points_);
    choose_ground(statistics);
    fill(scan, statistics);
  }
  finish(scan);
  return statistics;
}

void CloudToScan::Impl::clear(PlanarScan& scan, bool with_intensity) const {
  scan.angle_min = params_.angle_min;
  scan.angle_increment = params_.angle_increment;
  scan.angle_max = params_.angle_min + static_cast<double>(rays_ - 1) * params_.angle_increment;
  scan.ranges.assign(rays_, kNothing);
  scan.intensities.assign(with_intensity ? rays_ : 0, 0.0F);
}

void CloudToScan::Impl::choose_ground(ScanStatistics& statistics) const {
  if (params_.ground.method != GroundMethod::kPlane) return;
  const auto found = find_ground(points_, params_.ground);
  statistics.ground_found = found.has_value();
  if (found) statistics.ground = *found;
}

std::size_t CloudToScan::Impl::ray_of(float x, float y) const {
  constexpr auto kTurnF = static_cast<float>(kTurn);
  float from_edge = std::atan2(y, x) - first_edge_rad_;
  while (from_edge < 0) from_edge += kTurnF;
  while (from_edge >= kTurnF) from_edge -= kTurnF;
  const auto ray = static_cast<std::size_t>(from_edge * rays_per_rad_);
  return full_turn_ && ray == rays_ ? 0 : ray;
}

/// Until finish(), `scan.ranges` holds squares: one root per ray instead of one per point.
void CloudToScan::Impl::fill(PlanarScan& scan, ScanStatistics& statistics) const {
  const auto lowest = static_cast<float>(params_.min_height);
  const auto highest = static_cast<float>(params_.max_height);
  const auto nearest = static_cast<float>(params_.range_min * params_.range_min);
  const auto farthest = static_cast<float>(params_.range_max * params_.range_max);
  const bool has_ground = params_.ground.method != GroundMethod::kNone;
  const auto clearance = static_cast<float>(params_.ground.clearance_m);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const float x = points_.x[i];
    const float y = points_.y[i];
    const float z = points_.z[i];
    const float squared_range = x * x + y * y;
    // Written so that NaN fails.
    if (!(z >= lowest && z <= highest && squared_range >= nearest && squared_range <= farthest)) continue;
    if (has_ground && statistics.ground.height({x, y, z}) < clearance) {
      ++statistics.on_ground;
      continue;
    }
    const std::size_t ray = ray_of(x, y);
    if (ray >= rays_) continue;
    ++statistics.used;
    add(i, ray, squared_range, scan);
  }
}

void CloudToScan::Impl::add(std::size_t point, std::size_t ray, float squared_range, PlanarScan& scan) const {
  const bool is_nearest = squared_range < scan.ranges[ray];
  if (is_nearest) scan.ranges[ray] = squared_range;
  if (scan.intensities.empty()) return;
  float& intensity = scan.intensities[ray];
  const float value = points_.intensity[point];
  if (params_.intensity == IntensityOf::kMaximum ? value > intensity : is_nearest) intensity = value;
}

void CloudToScan::Impl::finish(PlanarScan& scan) const {
  const float nothing =
      params_.use_inf ? kNothing : static_cast<float>(params_.range_max + params_.inf_epsilon);
  for (float& range : scan.ranges) range = range == kNothing ? nothing : std::sqrt(range);
}

Result<CloudToScan> CloudToScan::make(const ScanParams& params) {
  if (auto valid = validate(params); !valid) return tl::unexpected(valid.error());
  return CloudToScan(std::make_unique<Impl>(params));
}

CloudToScan::CloudToScan(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CloudToScan::CloudToScan(CloudToScan&&) noexcept = default;
CloudToScan& CloudToScan::operator=(CloudToScan&&) noexcept = default;
CloudToScan::~CloudToScan() = default;

Result<ScanStatistics> CloudToScan::convert(const CloudView& cloud, const Pose& target_T_cloud,
                                            PlanarScan& scan) {
  return impl_->convert(cloud, target_T_cloud, scan);
}

std::size_t CloudToScan::rays() const {
  return impl_->rays();
}

}  // namespace extperfc::scan
