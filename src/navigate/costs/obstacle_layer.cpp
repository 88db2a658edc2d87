#include "extperfc/navigate/obstacle_layer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "extperfc/base/demand.hpp"
#include "extperfc/base/math.hpp"

#include "navigate/costs/polygon.hpp"
#include "navigate/costs/ray.hpp"
#include "navigate/costs/row_spans.hpp"

namespace extperfc::navigate {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::int32_t kNeverSeen = -2;
constexpr std::int32_t kSeenFree = -1;
constexpr std::size_t kDirections = 720;
constexpr double kHalfDiagonal = 0.7071067811865476;  // of a cell [cells]

/// What a range of a scan says.
struct Range {
  bool valid{false};
  bool returned{false};
  double range_m{0};
};

Range range_of(const LaserScan& scan, float range_m, bool inf_is_valid) {
  if (is_return(scan, range_m)) return {true, true, range_m};
  if (range_m > scan.range_max && inf_is_valid) return {true, false, scan.range_max};
  return {};
}

double direction_of(double angle_rad) {
  const double direction = std::fmod(angle_rad, kTwoPi);
  return direction < 0 ? direction + kTwoPi : direction;
}

std::size_t direction_bin(double angle_rad) {
  return std::min(static_cast<std::size_t>(direction_of(angle_rad) / kTwoPi * kDirections), kDirections - 1);
}

}  // namespace

ObstacleLayer::ObstacleLayer(const ObstacleParams& params) : params_(params) {
  demand(params.keep_s >= 0 && params.decay_s >= params.keep_s && params.unseen_decay_s > 0 &&
             params.unseen_decay_s >= params.decay_s,
         "obstacles: 0 <= keep_s <= decay_s <= unseen_decay_s must hold, the last above 0");
  demand(params.height_tolerance_m >= 0, "obstacles: height_tolerance_m must be 0 or more");
  demand(params.blind_m >= 0, "obstacles: blind_m must be 0 or more");
}

Result<void> ObstacleLayer::observe(const LaserScan& scan, const Pose2& grid_T_sensor, double height_m,
                                    const SensorParams& sensor) {
  if (auto valid = validate(scan); !valid) return valid;
  if (!is_finite(grid_T_sensor) || !std::isfinite(height_m))
    return fail(ErrorCode::kInvalidArgument, "the pose of a scan's sensor must be finite");
  if (!(sensor.half_fov_rad >= 0 && sensor.half_fov_rad < kPi / 2))
    return fail(ErrorCode::kInvalidArgument, "half_fov_rad must be from 0 to below pi / 2");
  const bool fan = !scan.heights_m.empty();
  Observation observation{scan.stamp_s, {grid_T_sensor.x, grid_T_sensor.y, height_m}, {}};
  if (fan) observation.rise = std::tan(sensor.half_fov_rad);
  scanner_m_ = observation.sensor_m.head<2>();
  observation.rays.reserve(scan.ranges.size());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const Range range = range_of(scan, scan.ranges[i], sensor.inf_is_valid);
    if (!range.valid) continue;
    const double angle = grid_T_sensor.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    Vector3d end_m = observation.sensor_m + range.range_m * Vector3d(std::cos(angle), std::sin(angle), 0);
    if (fan && range.returned) end_m.z() = scan.heights_m[i];
    observation.rays.push_back({end_m, range.range_m, range.returned});
  }
  constexpr double kAny = std::numeric_limits<double>::infinity();
  take(observation, sensor, fan ? Band{-kAny, kAny} : Band{height_m, height_m});
  if (sensor.clears) clear_between_rays(scan, grid_T_sensor, height_m, sensor);
  return {};
}

Result<void> ObstacleLayer::observe(const PointObservation& cloud, const SensorParams& sensor) {
  if (!std::isfinite(cloud.stamp_s) || !cloud.sensor_m.allFinite())
    return fail(ErrorCode::kInvalidArgument, "the stamp and the sensor's position of a cloud must be finite");
  Observation observation{cloud.stamp_s, cloud.sensor_m, {}};
  observation.rays.reserve(cloud.points_m.size());
  for (const auto& point_m : cloud.points_m) {
    if (!point_m.allFinite()) continue;
    const Vector3d end_m = point_m.cast<double>();
    observation.rays.push_back({end_m, (end_m - cloud.sensor_m).head<2>().norm(), true});
  }
  take(observation, sensor, {sensor.min_obstacle_height_m, sensor.max_obstacle_height_m});
  return {};
}

void ObstacleLayer::take(const Observation& observation, const SensorParams& sensor, const Band& band) {
  if (sensor.marks)
    for (const Ray& ray : observation.rays)
      if (ray.returned && ray.range_m <= sensor.obstacle_range_m && ray.end_m.z() >= band.low_m &&
          ray.end_m.z() <= band.high_m)
        mark(ray, observation.stamp_s, observation.rise.has_value());
  if (!sensor.clears) return;
  const auto wanted = directions_to_clear(observation, sensor.raytrace_range_m);
  if (wanted.empty() && !params_.frees_unknown) return;
  const Vector2d sensor_m = observation.sensor_m.head<2>();
  for (const Ray& ray : observation.rays) {
    const Vector2d along = ray.end_m.head<2>() - sensor_m;
    if (params_.frees_unknown || wanted[direction_bin(std::atan2(along.y(), along.x()))])
      clear_along(observation, ray, sensor.raytrace_range_m);
  }
}

/// A fan shows the nearest of several heights: the last one says from where the cell can be seen.
void ObstacleLayer::mark(const Ray& ray, double stamp_s, bool fan) {
  const auto cell = shape_.cell_of(ray.end_m.head<2>());
  if (!cell) return;
  const std::size_t index = shape_.index(*cell);
  const auto height_m = static_cast<float>(ray.end_m.z());
  if (slots_[index] >= 0) {
    Mark& known = marks_[static_cast<std::size_t>(slots_[index])];
    if (fan && stamp_s > known.stamp_s)
      known = {index, stamp_s, height_m, height_m};
    else
      known.join({index, stamp_s, height_m, height_m});
    return;
  }
  slots_[index] = static_cast<std::int32_t>(marks_.size());
  marks_.push_back({index, stamp_s, height_m, height_m});
  note_change(index);
}

std::vector<bool> ObstacleLayer::directions_to_clear(const Observation& observation,
                                                     double raytrace_range_m) const {
  std::vector<bool> wanted;
  const Vector2d sensor_m = observation.sensor_m.head<2>();
  const double around_m = kHalfDiagonal * shape_.resolution_m;
  for (const Mark& mark : marks_) {
    if (!may_clear(mark, observation.stamp_s)) continue;
    const Vector2d to_mark = shape_.middle_of(cell_at(mark.index)) - sensor_m;
    const double distance_m = to_mark.norm();
    if (distance_m - around_m > raytrace_range_m) continue;
    if (distance_m <= 1.01 * around_m) return std::vector<bool>(kDirections, true);
    wanted.resize(kDirections, false);
    const double half_width = std::asin(around_m / distance_m) + 1e-6;
    const double begin = direction_of(std::atan2(to_mark.y(), to_mark.x()) - half_width);
    constexpr double kBin = kTwoPi / kDirections;
    for (double angle = begin; angle < begin + 2 * half_width + kBin; angle += kBin)
      wanted[direction_bin(angle)] = true;
  }
  return wanted;
}

void ObstacleLayer::clear_along(const Observation& observation, const Ray& ray, double raytrace_range_m) {
  const auto in_cells = [&](const Vector3d& point_m) -> Vector2d {
    return (point_m.head<2>() - shape_.origin_m) / shape_.resolution_m;
  };
  const Vector3d& from_m = observation.sensor_m;
  const bool cut = ray.range_m > raytrace_range_m;
  const Vector3d to_m =
      cut ? Vector3d(from_m + raytrace_range_m / ray.range_m * (ray.end_m - from_m)) : ray.end_m;
  const Vector2d end = in_cells(to_m);
  const Vector2d end_cell = end.array().floor();
  const bool spares_end = ray.returned && !cut;
  const double length_m = (to_m - from_m).head<2>().norm();
  visit_ray(shape_, in_cells(from_m), end, [&](Cell cell, double enter, double leave) {
    if (spares_end && cell.column == end_cell.x() && cell.row == end_cell.y()) return;
    if (observation.rise) {
      const double half_m = *observation.rise * 0.5 * (enter + leave) * length_m;
      pass(shape_.index(cell), {from_m.z() - half_m, from_m.z() + half_m}, observation.stamp_s, true);
      return;
    }
    const double z_enter = from_m.z() + enter * (to_m.z() - from_m.z());
    const double z_leave = from_m.z() + leave * (to_m.z() - from_m.z());
    pass(shape_.index(cell), {std::min(z_enter, z_leave), std::max(z_enter, z_leave)}, observation.stamp_s,
         false);
  });
}

/// A line must meet the heights of a mark, a fan must hold them.
bool ObstacleLayer::is_seen(const Mark& mark, const Band& heights, bool fan) const {
  if (fan) return heights.low_m <= mark.low_m && heights.high_m >= mark.high_m;
  return heights.low_m <= mark.high_m + params_.height_tolerance_m &&
         heights.high_m >= mark.low_m - params_.height_tolerance_m;
}

void ObstacleLayer::pass(std::size_t index, const Band& heights, double stamp_s, bool fan) {
  if (slots_[index] == kNeverSeen) {
    slots_[index] = kSeenFree;
    if (params_.frees_unknown) note_change(index);
  }
  if (slots_[index] < 0) return;
  const auto slot = static_cast<std::size_t>(slots_[index]);
  const Mark& mark = marks_[slot];
  if (is_seen(mark, heights, fan) && may_clear(mark, stamp_s)) erase(slot);
}

void ObstacleLayer::clear_between_rays(const LaserScan& scan, const Pose2& grid_T_sensor, double height_m,
                                       const SensorParams& sensor) {
  const bool fan = !scan.heights_m.empty();
  const double around_m = kHalfDiagonal * shape_.resolution_m;
  const auto passes = [&](double index, double distance_m) {
    const Range range = range_of(scan, scan.ranges[static_cast<std::size_t>(index)], sensor.inf_is_valid);
    return range.valid && range.range_m > distance_m + around_m;
  };
  for (std::size_t slot = marks_.size(); slot-- > 0;) {
    const Mark& mark = marks_[slot];
    if (!(scan.stamp_s - mark.stamp_s > params_.decay_s)) continue;
    const Vector2d middle_m = shape_.middle_of(cell_at(mark.index));
    const Vector2d to_mark = middle_m - Vector2d(grid_T_sensor.x, grid_T_sensor.y);
    const double distance_m = to_mark.norm();
    const double half_m = fan ? std::tan(sensor.half_fov_rad) * distance_m : 0;
    if (!is_seen(mark, {height_m - half_m, height_m + half_m}, fan)) continue;
    if (distance_m + around_m > sensor.raytrace_range_m) continue;
    const double angle = std::atan2(to_mark.y(), to_mark.x()) - grid_T_sensor.yaw - scan.angle_min;
    const double index =
        direction_of(scan.angle_increment > 0 ? angle : -angle) / std::abs(scan.angle_increment);
    const double count = static_cast<double>(scan.ranges.size());
    const bool whole_circle = (count + 0.5) * std::abs(scan.angle_increment) > kTwoPi;
    const double next = whole_circle && std::ceil(index) >= count ? 0 : std::ceil(index);
    if (std::floor(index) < count && next < count && passes(std::floor(index), distance_m) &&
        passes(next, distance_m))
      erase(slot);
  }
}

void ObstacleLayer::clear_footprint(const Footprint& footprint, const Pose2& grid_T_base) {
  if (shape_.width == 0 || !is_finite(grid_T_base)) return;
  const Pose2 base_T_grid = inverse(grid_T_base);
  const double c = std::cos(base_T_grid.yaw);
  const double s = std::sin(base_T_grid.yaw);
  const ToCells to_cells(shape_, grid_T_base);
  for (const auto& part_m : footprint.convex_parts_m()) {
    const Bounds bounds(part_m, to_cells);
    if (!bounds.is_finite()) return;
    visit_rows(shape_, part_m, to_cells, bounds, [&](int row, int begin, int end) {
      for (int column = begin; column < end; ++column) {
        const std::size_t index = shape_.index({column, row});
        const bool never_seen = slots_[index] == kNeverSeen && params_.frees_unknown;
        if (slots_[index] < 0 && !never_seen) continue;
        const Vector2d m = shape_.middle_of({column, row});
        const Vector2d in_base(c * m.x() - s * m.y() + base_T_grid.x, s * m.x() + c * m.y() + base_T_grid.y);
        if (!contains(footprint.corners_m(), in_base)) continue;
        if (!never_seen) {
          erase(static_cast<std::size_t>(slots_[index]));
        } else {
          slots_[index] = kSeenFree;
          note_change(index);
        }
      }
      return true;
    });
  }
}

void ObstacleLayer::level(const Vector2d& middle_m, double radius_m, double height_m) {
  const auto height = static_cast<float>(height_m);
  for (Mark& mark : marks_)
    if ((shape_.middle_of(cell_at(mark.index)) - middle_m).squaredNorm() <= square(radius_m))
      mark.low_m = mark.high_m = height;
}

void ObstacleLayer::clear_beyond(const Vector2d& middle_m, double radius_m) {
  for (std::size_t slot = marks_.size(); slot-- > 0;)
    if ((shape_.middle_of(cell_at(marks_[slot].index)) - middle_m).norm() > radius_m) erase(slot);
}

void ObstacleLayer::match(const CostGrid& grid) {
  CostGrid shape = grid;
  shape.cells.clear();
  std::vector<std::int32_t> slots(grid.cells.size(), kNeverSeen);
  std::vector<Mark> marks;
  marks.reserve(marks_.size());
  for (std::size_t index = 0; index < slots_.size(); ++index) {
    if (slots_[index] == kNeverSeen) continue;
    const auto cell = shape.cell_of(shape_.middle_of(cell_at(index)));
    if (!cell) continue;
    std::int32_t& slot = slots[shape.index(*cell)];
    if (slots_[index] == kSeenFree) {
      slot = std::max(slot, kSeenFree);
      continue;
    }
    Mark mark = marks_[static_cast<std::size_t>(slots_[index])];
    mark.index = shape.index(*cell);
    if (slot < 0) {
      slot = static_cast<std::int32_t>(marks.size());
      marks.push_back(mark);
    } else {
      marks[static_cast<std::size_t>(slot)].join(mark);
    }
  }
  shape_ = std::move(shape);
  slots_ = std::move(slots);
  marks_ = std::move(marks);
  changed_ = {};
}

CellBox ObstacleLayer::take_changes(const CostGrid& /*grid*/, double now_s) {
  for (std::size_t slot = marks_.size(); slot-- > 0;) {
    marks_[slot].stamp_s = std::min(marks_[slot].stamp_s, now_s);  // the clock may have been set back
    if (now_s - marks_[slot].stamp_s <= params_.unseen_decay_s) continue;
    const bool blind =
        scanner_m_ && (shape_.middle_of(cell_at(marks_[slot].index)) - *scanner_m_).norm() < params_.blind_m;
    if (!blind) erase(slot);
  }
  return std::exchange(changed_, CellBox{});
}

void ObstacleLayer::write(CostGrid& grid, const CellBox& box) {
  for (int row = box.min.row; row < box.max.row; ++row) {
    for (int column = box.min.column; column < box.max.column; ++column) {
      const std::int32_t slot = slots_[shape_.index({column, row})];
      Cost& cost = grid.at({column, row});
      if (slot >= 0) cost = kLethalCost;
      if (slot == kSeenFree && params_.frees_unknown && cost == kUnknownCost) cost = kFreeCost;
    }
  }
}

void ObstacleLayer::clear() {
  std::fill(slots_.begin(), slots_.end(), kNeverSeen);
  marks_.clear();
  changed_ = shape_.box();
}

void ObstacleLayer::Mark::join(const Mark& other) {
  stamp_s = std::max(stamp_s, other.stamp_s);
  low_m = std::min(low_m, other.low_m);
  high_m = std::max(high_m, other.high_m);
}

Cell ObstacleLayer::cell_at(std::size_t index) const {
  const auto width = static_cast<std::size_t>(shape_.width);
  return {static_cast<int>(index % width), static_cast<int>(index / width)};
}

/// The last mark takes the place of the one that goes.
void ObstacleLayer::erase(std::size_t slot) {
  note_change(marks_[slot].index);
  slots_[marks_[slot].index] = kSeenFree;
  marks_[slot] = marks_.back();
  marks_.pop_back();
  if (slot < marks_.size()) slots_[marks_[slot].index] = static_cast<std::int32_t>(slot);
}

void ObstacleLayer::note_change(std::size_t index) {
  const Cell cell = cell_at(index);
  changed_ = changed_.joined({cell, {cell.column + 1, cell.row + 1}});
}

}  // namespace extperfc::navigate
