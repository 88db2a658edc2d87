#include "extperfc/offline/map_recording.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <optional>
#include <utility>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"

namespace extperfc::offline {

namespace {

constexpr std::size_t kMaxComplaints = 10;

/// What must be known of a scan to give it a pose in the end.
struct Passed {
  double stamp_s{0};
  std::size_t index{0};
  bool taken{false};
  std::optional<Pose2> since_taken;  // motion since the last accepted scan, for refused ones
};

class Run {
 public:
  Run(sources::ScanLog& log, mapping::Mapper& mapper, const MappingOptions& options)
      : log_(log), mapper_(mapper), options_(options), before_(mapper.trajectory().size()) {}

  MappingResult result();

 private:
  /// False when the recording is over or broken.
  bool step();
  void add(sources::ScanRecord record);
  void note_odometry(const std::optional<Pose2>& odom_T_base);
  void complete();
  void place_scans();

  sources::ScanLog& log_;
  mapping::Mapper& mapper_;
  const MappingOptions& options_;
  std::size_t before_;  // poses of the session that is continued
  MappingResult result_;
  std::vector<Passed> passed_;
  std::vector<double> cpu_ms_;
  std::optional<Pose2> last_odometry_;
  std::optional<Pose2> taken_odometry_;
};

bool Run::step() {
  if (passed_.size() >= options_.max_scans) return false;
  if (options_.should_continue && !options_.should_continue({log_.progress(), passed_.size()})) {
    result_.interrupted = true;
    return false;
  }
  auto record = log_.next();
  if (!record) {
    result_.broken = record.error().message;
    return false;
  }
  if (!*record) return false;
  if (!options_.use_odometry) (*record)->odom_T_base.reset();
  add(**std::move(record));
  return true;
}

void Run::add(sources::ScanRecord record) {
  if (passed_.empty()) result_.base_T_scanner = record.scan.base_T_sensor;
  note_odometry(record.odom_T_base);
  const double start_s = process_cpu_seconds();
  const auto update = mapper_.add(record.scan, record.odom_T_base);
  if (mapper_.wants_search()) mapper_.optimize();
  cpu_ms_.push_back(1e3 * (process_cpu_seconds() - start_s));
  Passed passed{record.scan.stamp_s, record.index, update.has_value(), std::nullopt};
  if (update) {
    taken_odometry_ = record.odom_T_base;
  } else {
    ++result_.refused;
    if (taken_odometry_ && record.odom_T_base)
      passed.since_taken = between(*taken_odometry_, *record.odom_T_base);
    if (result_.complaints.size() < kMaxComplaints)
      result_.complaints.push_back("scan " + std::to_string(record.index) + ": " + update.error().message);
  }
  passed_.push_back(passed);
}

void Run::note_odometry(const std::optional<Pose2>& odom_T_base) {
  if (!odom_T_base) {
    ++result_.without_odometry;
    return;
  }
  if (last_odometry_)
    result_.odometry_m += std::hypot(odom_T_base->x - last_odometry_->x, odom_T_base->y - last_odometry_->y);
  last_odometry_ = odom_T_base;
}

void Run::place_scans() {
  const Trajectory known = mapper_.trajectory();
  std::size_t next = before_;
  Pose2 last;
  for (const auto& scan : passed_) {
    if (scan.taken && next < known.size()) last = known[next++].pose;
    const Pose2 pose = scan.since_taken ? compose(last, *scan.since_taken) : last;
    result_.trajectory.push_back({scan.stamp_s, pose});
    result_.scan_index.push_back(scan.index);
  }
}

void Run::complete() {
  result_.scans = passed_.size();
  result_.damaged = log_.damaged();
  const auto& damage = log_.complaints();
  result_.complaints.insert(result_.complaints.begin(), damage.begin(), damage.end());
  if (passed_.empty()) return;
  const auto [first, last] = std::minmax_element(
      passed_.begin(), passed_.end(), [](const Passed& a, const Passed& b) { return a.stamp_s < b.stamp_s; });
  result_.recorded_s = last->stamp_s - first->stamp_s;
  result_.cpu_ms.mean =
      std::accumulate(cpu_ms_.begin(), cpu_ms_.end(), 0.0) / static_cast<double>(cpu_ms_.size());
  result_.cpu_ms.p50 = percentile(cpu_ms_, 0.5);
  result_.cpu_ms.p99 = percentile(cpu_ms_, 0.99);
  result_.cpu_ms.max = percentile(cpu_ms_, 1.0);
}

MappingResult Run::result() {
  const Stopwatch wall;
  const double start_s = process_cpu_seconds();
  while (step()) {
  }
  mapper_.finish();
  result_.cpu_s = process_cpu_seconds() - start_s;
  result_.wall_s = wall.seconds();
  complete();
  place_scans();
  return std::move(result_);
}

}  // namespace

MappingResult map_recording(sources::ScanLog& log, mapping::Mapper& mapper, const MappingOptions& options) {
  return Run(log, mapper, options).result();
}

double peak_memory_mb() {
  // Not getrusage(): its figure begins with that of the program that started this one.
  std::ifstream status("/proc/self/status");
  for (std::string token; status >> token;) {
    double kib = 0;
    if (token == "VmHWM:" && status >> kib) return kib * 1024 / 1e6;
  }
  return 0;
}

}  // namespace extperfc::offline
