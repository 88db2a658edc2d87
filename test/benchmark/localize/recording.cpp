#include "test/benchmark/localize/recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/mapping/mapper.hpp"
#include "extperfc/sources/scan_log.hpp"

namespace extperfc::benchmark {

namespace {

Result<std::vector<Pose2>> map_it(const Recording& recording) {
  auto mapper = mapping::Mapper::make({});
  if (!mapper) return tl::unexpected(mapper.error());
  for (std::size_t i = 0; i < recording.scans.size(); ++i)
    if (const auto added = mapper->add(recording.scans[i], recording.odom[i]); !added)
      return tl::unexpected(added.error());
  mapper->finish();
  std::vector<Pose2> poses;
  for (const auto& stamped : mapper->trajectory()) poses.push_back(stamped.pose);
  return poses;
}

Result<std::vector<Pose2>> read_it(const std::filesystem::path& trajectory) {
  const auto read = read_tum(trajectory);
  if (!read) return tl::unexpected(read.error());
  std::vector<Pose2> poses;
  for (const auto& stamped : *read) poses.push_back(stamped.pose);
  return poses;
}

/// Rays that came by, and that ended, by cell.
class Counts {
 public:
  explicit Counts(const std::vector<Pose2>& poses) {
    constexpr double kMargin_m = 15;
    double right = -1e9;
    double top = -1e9;
    map_->origin = {1e9, 1e9, 0};
    for (const Pose2& pose : poses) {
      map_->origin.x = std::min(map_->origin.x, pose.x - kMargin_m);
      map_->origin.y = std::min(map_->origin.y, pose.y - kMargin_m);
      right = std::max(right, pose.x + kMargin_m);
      top = std::max(top, pose.y + kMargin_m);
    }
    for (double* corner : {&map_->origin.x, &map_->origin.y})  // where MRPT would round it to
      *corner = std::floor(*corner / map_->resolution_m) * map_->resolution_m;
    map_->width = static_cast<std::size_t>((right - map_->origin.x) / map_->resolution_m);
    map_->height = static_cast<std::size_t>((top - map_->origin.y) / map_->resolution_m);
    by_.assign(map_->width * map_->height, 0);
    ended_ = by_;
  }

  void add(const LaserScan& scan, const Pose2& pose) {
    constexpr double kLongest_m = 30;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double range = scan.ranges[i];
      if (!(range > scan.range_min) || range > std::min(kLongest_m, scan.range_max)) continue;
      const double angle = pose.yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double step = map_->resolution_m / 2;
      for (double range_m = 0; range_m < range - 2 * step; range_m += step) count(by_, pose, angle, range_m);
      count(ended_, pose, angle, range);
    }
  }

  [[nodiscard]] std::shared_ptr<OccupancyGrid> map() {
    map_->cells.resize(by_.size());
    for (std::size_t i = 0; i < by_.size(); ++i) {
      const int all = by_[i] / 2 + ended_[i];  // two steps in a cell
      map_->cells[i] = all == 0              ? OccupancyGrid::kUnknown
                       : 8 * ended_[i] > all ? OccupancyGrid::kOccupied
                                             : OccupancyGrid::kFree;
    }
    return map_;
  }

 private:
  void count(std::vector<int>& counts, const Pose2& pose, double angle, double range_m) {
    const auto cell = map_->cell_of(pose.x + range_m * std::cos(angle), pose.y + range_m * std::sin(angle));
    if (cell) ++counts[cell->row * map_->width + cell->column];
  }

  std::shared_ptr<OccupancyGrid> map_{std::make_shared<OccupancyGrid>()};
  std::vector<int> by_;
  std::vector<int> ended_;
};

}  // namespace

Result<Recording> load_recording(const std::filesystem::path& log, const std::filesystem::path& trajectory,
                                 std::size_t max_scans) {
  auto opened = sources::open_carmen_log(log);
  if (!opened) return tl::unexpected(opened.error());
  Recording recording;
  while (recording.scans.size() < max_scans) {
    auto record = (*opened)->next();
    if (!record) return tl::unexpected(record.error());
    if (!*record) break;
    if (!(*record)->odom_T_base) return fail(ErrorCode::kCorrupt, log.string() + " has no odometry");
    recording.odom.push_back(*(*record)->odom_T_base);
    recording.scans.push_back(std::move((*record)->scan));
  }
  auto truth = trajectory.empty() ? map_it(recording) : read_it(trajectory);
  if (!truth) return tl::unexpected(truth.error());
  if (truth->size() < recording.scans.size())
    return fail(ErrorCode::kCorrupt, "the trajectory has " + std::to_string(truth->size()) + " poses for " +
                                         std::to_string(recording.scans.size()) + " scans");
  truth->resize(recording.scans.size());
  recording.truth = std::move(*truth);
  return recording;
}

std::vector<std::size_t> key_frames(const Recording& recording) {
  constexpr double kDistance_m = 0.5;
  constexpr double kRotation_rad = 0.5;
  std::vector<std::size_t> frames{0};
  for (std::size_t i = 1; i < recording.truth.size(); ++i) {
    const Pose2 moved = between(recording.truth[frames.back()], recording.truth[i]);
    if (std::hypot(moved.x, moved.y) > kDistance_m || std::abs(moved.yaw) > kRotation_rad)
      frames.push_back(i);
  }
  return frames;
}

std::vector<std::size_t> every_second(const std::vector<std::size_t>& frames) {
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < frames.size(); k += 2) chosen.push_back(frames[k]);
  return chosen;
}

std::shared_ptr<OccupancyGrid> draw_map(const Recording& recording, const std::vector<std::size_t>& frames) {
  Counts counts(recording.truth);
  for (const std::size_t frame : frames)
    counts.add(recording.scans[frame], compose(recording.truth[frame], recording.scans[frame].base_T_sensor));
  return counts.map();
}

}  // namespace extperfc::benchmark
