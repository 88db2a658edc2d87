#include "test/benchmark/map/log_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <numeric>
#include <optional>
#include <utility>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/mapping/mapper.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "test/benchmark/map/score.hpp"

namespace extperfc::benchmark {
namespace {

std::vector<std::string> arguments_of(const LogRun& run) {
  return {"log",
          run.recording.log.string(),
          run.recording.relations.string(),
          std::to_string(run.particles),
          std::to_string(run.seed),
          std::to_string(run.scans),
          std::to_string(run.map_every_s),
          std::to_string(run.linear_update_m),
          run.rotation_counts ? "1" : "0"};
}

constexpr std::size_t kTokens = 8;  // behind "log"

LogRun run_of(const std::vector<std::string>& tokens) {
  LogRun run;
  run.recording = {tokens[0], tokens[1]};
  run.particles = std::atoi(tokens[2].c_str());
  run.seed = std::strtoull(tokens[3].c_str(), nullptr, 10);
  run.scans = std::strtoull(tokens[4].c_str(), nullptr, 10);
  run.map_every_s = std::strtod(tokens[5].c_str(), nullptr);
  run.linear_update_m = std::strtod(tokens[6].c_str(), nullptr);
  run.rotation_counts = tokens[7] == "1";
  return run;
}

mapping::MapperParams params_of(const LogRun& run) {
  mapping::MapperParams params;
  params.particles = run.particles;
  params.seed = run.seed;
  if (run.linear_update_m > 0) params.linear_update_m = run.linear_update_m;
  if (!run.rotation_counts) params.angular_update_rad = M_PI;
  return params;
}

double mean_of(const std::vector<double>& values, std::size_t first, std::size_t last) {
  const auto at = [&](std::size_t i) { return values.begin() + static_cast<std::ptrdiff_t>(i); };
  return first < last ? std::accumulate(at(first), at(last), 0.0) / static_cast<double>(last - first) : 0.0;
}

/// A mapper that is fed and watched.
class Watched {
 public:
  Watched(mapping::Mapper mapper, LogRun run) : mapper_(std::move(mapper)), run_(std::move(run)) {}

  Result<void> feed(sources::ScanLog& log);
  [[nodiscard]] Figures figures();
  [[nodiscard]] Trajectory trajectory() const { return mapper_.trajectory(); }

 private:
  [[nodiscard]] Result<void> add(const sources::ScanRecord& record);
  void call_map(double stamp_s);
  void note_scan_times(Figures& figures);
  void note_map_times(Figures& figures) const;

  mapping::Mapper mapper_;
  LogRun run_;
  std::vector<double> scan_ms_;
  std::vector<std::pair<std::size_t, double>> map_ms_;  // after how many scans, and the call's time
  double cpu_s_{0};
  double base_mb_{0};
  std::optional<double> last_map_s_;
  double first_stamp_s_{0};
  double last_stamp_s_{0};
};

Result<void> Watched::feed(sources::ScanLog& log) {
  base_mb_ = offline::peak_memory_mb();
  const double start_s = process_cpu_seconds();
  while (scan_ms_.size() < run_.scans) {
    auto record = log.next();
    if (!record) return tl::unexpected(record.error());
    if (!*record) break;
    if (auto added = add(**record); !added) return added;
    if (run_.map_every_s > 0) call_map((*record)->scan.stamp_s);
  }
  mapper_.finish();
  cpu_s_ = process_cpu_seconds() - start_s;
  if (scan_ms_.empty()) return fail(ErrorCode::kCorrupt, run_.recording.log.string() + " holds no scans");
  return {};
}

Result<void> Watched::add(const sources::ScanRecord& record) {
  if (scan_ms_.empty()) first_stamp_s_ = record.scan.stamp_s;
  last_stamp_s_ = record.scan.stamp_s;
  const double start_s = process_cpu_seconds();
  const auto update = mapper_.add(record.scan, record.odom_T_base);
  scan_ms_.push_back(1e3 * (process_cpu_seconds() - start_s));
  if (!update) return tl::unexpected(update.error());
  return {};
}

/// As a node publishes: at a bounded rate. Stamps may run backwards.
void Watched::call_map(double stamp_s) {
  if (last_map_s_ && std::abs(stamp_s - *last_map_s_) < run_.map_every_s) return;
  last_map_s_ = stamp_s;
  const double start_s = process_cpu_seconds();
  (void)mapper_.map();
  map_ms_.emplace_back(scan_ms_.size(), 1e3 * (process_cpu_seconds() - start_s));
}

void Watched::note_scan_times(Figures& figures) {
  const std::size_t n = scan_ms_.size();
  figures["scans"] = static_cast<double>(n);
  figures["scan_mean_ms"] = mean_of(scan_ms_, 0, n);
  figures["first_quarter_ms"] = mean_of(scan_ms_, 0, n / 4);
  figures["last_quarter_ms"] = mean_of(scan_ms_, n - n / 4, n);
  figures["scan_p99_ms"] = percentile(scan_ms_, 0.99);  // reorders: last
  figures["scan_max_ms"] = percentile(scan_ms_, 1.0);
}

void Watched::note_map_times(Figures& figures) const {
  std::vector<double> last_quarter;
  figures["map_calls"] = static_cast<double>(map_ms_.size());
  for (const auto& [scans, ms] : map_ms_) {
    figures["map_max_ms"] = std::max(figures["map_max_ms"], ms);
    if (4 * scans >= 3 * scan_ms_.size()) last_quarter.push_back(ms);
  }
  if (!last_quarter.empty()) figures["map_last_median_ms"] = percentile(last_quarter, 0.5);
}

Figures Watched::figures() {
  Figures figures;
  const auto map = mapper_.map();
  figures["peak_mb"] = offline::peak_memory_mb();
  figures["base_mb"] = base_mb_;
  figures["cpu_s"] = cpu_s_;
  figures["seconds"] = last_stamp_s_ - first_stamp_s_;
  figures["map_cells"] = static_cast<double>(map->cells.size());
  const auto unknown = std::count(map->cells.begin(), map->cells.end(), OccupancyGrid::kUnknown);
  figures["explored_m2"] = (static_cast<double>(map->cells.size()) - static_cast<double>(unknown)) *
                           map->resolution_m * map->resolution_m;
  const auto statistics = mapper_.statistics();
  figures["key_frames"] = static_cast<double>(statistics.key_frames);
  figures["loops"] = static_cast<double>(statistics.loops);
  note_map_times(figures);
  note_scan_times(figures);
  return figures;
}

Result<Figures> watch(const LogRun& run) {
  auto log = sources::open_carmen_log(run.recording.log);
  if (!log) return tl::unexpected(log.error());
  auto mapper = mapping::Mapper::make(params_of(run));
  if (!mapper) return tl::unexpected(mapper.error());
  Watched watched(*std::move(mapper), run);
  if (auto fed = watched.feed(**log); !fed) return tl::unexpected(fed.error());
  Figures figures = watched.figures();
  if (run.recording.relations.empty()) return figures;
  std::vector<std::optional<Pose2>> poses;
  for (const auto& stamped : watched.trajectory()) poses.emplace_back(stamped.pose);
  if (auto scored = add_score(run.recording, poses, figures); !scored) return tl::unexpected(scored.error());
  return figures;
}

}  // namespace

Result<Figures> run_log(const LogRun& run) {
  return run_part(arguments_of(run));
}

int run_log_part(const std::vector<std::string>& tokens) {
  if (tokens.size() != kTokens) return 2;
  const auto figures = watch(run_of(tokens));
  if (!figures) {
    std::cerr << figures.error().message << "\n";
    return EXIT_FAILURE;
  }
  std::cout.precision(17);
  for (const auto& [name, value] : *figures) std::cout << name << ' ' << value << '\n';
  return EXIT_SUCCESS;
}

}  // namespace extperfc::benchmark
