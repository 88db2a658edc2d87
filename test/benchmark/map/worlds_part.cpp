#include "test/benchmark/map/worlds_part.hpp"

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

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/world_kinds.hpp"

namespace extperfc::benchmark {
namespace {

constexpr double kSampleEveryM = 0.5;
constexpr double kMinPathM = 15;  // between poses that see each other again
constexpr double kSeenM = 1.0;    // they truly stand this near
constexpr double kBadM = 0.5;

/// A place on the drive.
struct Sample {
  std::size_t scan{0};
  double path_m{0};
  Pose2 truth;
  Pose2 mapped;
};

double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

/// How far off the map has b as seen from a.
double pair_error(const Sample& a, const Sample& b) {
  return distance(between(a.truth, b.truth), between(a.mapped, b.mapped));
}

/// One error for every sample and every later time that the robot passes it: that of the nearest pose then.
std::vector<double> pair_errors(const std::vector<Sample>& samples) {
  std::vector<double> errors;
  for (auto a = samples.begin(); a != samples.end(); ++a) {
    const auto apart = [&](const Sample& b) { return distance(a->truth, b.truth); };
    const auto is_near = [&](const Sample& b) { return apart(b) <= kSeenM; };
    auto from =
        std::find_if(a, samples.end(), [&](const Sample& b) { return b.path_m - a->path_m >= kMinPathM; });
    while ((from = std::find_if(from, samples.end(), is_near)) != samples.end()) {
      const auto gone = std::find_if_not(from, samples.end(), is_near);
      const auto nearest =
          std::min_element(from, gone, [&](const Sample& b, const Sample& c) { return apart(b) < apart(c); });
      errors.push_back(pair_error(*a, *nearest));
      from = gone;
    }
  }
  return errors;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// A mapper on a drive.
class WorldRun {
 public:
  /// carried: from half of the drive on the robot is carried over a tenth of it; odometry does not notice.
  WorldRun(const WorldCase& world, std::uint64_t seed, mapping::Mapper mapper, bool carried)
      : has_odometry_(world.odometry.there), recorder_(world, seed), mapper_(std::move(mapper)) {
    if (!carried) return;
    WorldRecorder whole(world, seed);
    while (const auto step = whole.next()) path_m_ = step->path_m;
    carried_from_m_ = 0.5 * path_m_;
    carried_to_m_ = 0.6 * path_m_;
  }

  Result<Figures> run();
  /// Every half metre of the drive, as the map has it now.
  [[nodiscard]] std::vector<Sample> samples() const;

 private:
  template <typename Search>
  void add_search_time(const Search& search) {
    const double start_s = process_cpu_seconds();
    search();
    search_s_ += process_cpu_seconds() - start_s;
  }
  Result<void> add(const WorldRecorder::Step& step);

  struct Passed {
    std::size_t scan;
    double path_m;
    Pose2 truth;
  };
  bool has_odometry_;
  WorldRecorder recorder_;
  mapping::Mapper mapper_;
  std::vector<double> scan_ms_;
  double search_s_{0};          // besides
  std::vector<Passed> passed_;  // every half metre
  double path_m_{0};
  double carried_from_m_{0};
  double carried_to_m_{0};
  Pose2 odometry_;  // of the last step before the robot was carried
  Pose2 set_down_;  // of the first one after that, as the recording has it
};

Result<void> WorldRun::add(const WorldRecorder::Step& step) {
  path_m_ = step.path_m;
  if (passed_.empty() || path_m_ - passed_.back().path_m >= kSampleEveryM)
    passed_.push_back({scan_ms_.size(), path_m_, step.world_T_base});
  const auto odometry = has_odometry_
                            ? std::optional<Pose2>(compose(odometry_, between(set_down_, step.odom_T_base)))
                            : std::nullopt;
  const double start_s = process_cpu_seconds();
  const auto update = mapper_.add(step.scan, odometry);
  scan_ms_.push_back(1e3 * (process_cpu_seconds() - start_s));
  if (!update) return tl::unexpected(update.error());
  return {};
}

std::vector<Sample> WorldRun::samples() const {
  const Trajectory trajectory = mapper_.trajectory();
  std::vector<Sample> samples;
  for (const auto& [scan, path_m, truth] : passed_)
    samples.push_back({scan, path_m, truth, trajectory.at(scan).pose});
  return samples;
}

Result<Figures> WorldRun::run() {
  Pose2 before;
  while (const auto step = recorder_.next()) {
    if (step->path_m < carried_from_m_) before = step->odom_T_base;
    if (step->path_m >= carried_from_m_ && step->path_m < carried_to_m_) {
      odometry_ = before;
      set_down_ = step->odom_T_base;
      continue;
    }
    if (auto added = add(*step); !added) return tl::unexpected(added.error());
    if (mapper_.wants_search()) add_search_time([&] { mapper_.optimize(); });
  }
  add_search_time([&] { mapper_.finish(); });
  const auto passed = samples();
  const auto errors = pair_errors(passed);
  Figures figures;
  figures["scans"] = static_cast<double>(scan_ms_.size());
  figures["path_m"] = path_m_;
  figures["loops"] = static_cast<double>(mapper_.statistics().loops);
  figures["carried"] = static_cast<double>(mapper_.statistics().carried);
  figures["parts"] = static_cast<double>(mapper_.statistics().parts);
  figures["scan_mean_ms"] = mean_of(scan_ms_);
  figures["scan_p99_ms"] = percentile(scan_ms_, 0.99);
  figures["cpu_s"] = search_s_ + 1e-3 * mean_of(scan_ms_) * static_cast<double>(scan_ms_.size());
  figures["peak_mb"] = offline::peak_memory_mb();
  figures["pairs"] = static_cast<double>(errors.size());
  figures["bad_pairs"] = static_cast<double>(
      std::count_if(errors.begin(), errors.end(), [](double error_m) { return error_m > kBadM; }));
  if (!errors.empty()) figures["pair_error_m"] = mean_of(errors);
  figures["end_error_m"] = pair_error(passed.front(), passed.back());
  figures["end_sigma_m"] = mapper_.statistics().position_sigma_m;
  return figures;
}

/// A table of the drive for a plot: scan, path, true pose, pose in the map [m, rad].
/// Errors: the file cannot be written.
Result<void> write(const std::vector<Sample>& samples, const std::string& file) {
  std::ofstream out(file);
  for (const auto& [scan, path_m, truth, mapped] : samples)
    out << scan << ' ' << path_m << ' ' << truth.x << ' ' << truth.y << ' ' << truth.yaw << ' ' << mapped.x
        << ' ' << mapped.y << ' ' << mapped.yaw << '\n';
  if (!out.flush()) return fail(ErrorCode::kFailed, "cannot write the drive to " + file);
  return {};
}

Result<Figures> run_world(const std::string& kind, std::uint64_t seed, bool carried,
                          const std::optional<std::string>& table) {
  const auto world = make_world(kind, seed);
  if (!world) return tl::unexpected(world.error());
  auto mapper = mapping::Mapper::make({});
  if (!mapper) return tl::unexpected(mapper.error());
  WorldRun run(*world, seed, *std::move(mapper), carried);
  auto figures = run.run();
  if (!figures || !table) return figures;
  if (auto written = write(run.samples(), *table); !written) return tl::unexpected(written.error());
  return figures;
}

void say(const std::string& kind, int seed, const Figures& run) {
  std::cerr << "  " << kind << ", seed " << seed << ": " << run.at("path_m") << " m, " << run.at("scans")
            << " scans, " << run.at("pairs") << " pairs";
  if (run.count("pair_error_m") != 0) std::cerr << ", off by " << run.at("pair_error_m") << " m";
  std::cerr << ", " << run.at("scan_mean_ms") << " ms per scan" << std::endl;
}

double sum_of(const std::vector<Figures>& runs, const std::string& name) {
  return std::accumulate(runs.begin(), runs.end(), 0.0,
                         [&](double sum, const Figures& run) { return sum + run.at(name); });
}

/// Of those runs that have this figure.
std::vector<double> values_of(const std::vector<Figures>& runs, const std::string& name) {
  std::vector<double> values;
  for (const auto& run : runs)
    if (const auto found = run.find(name); found != run.end()) values.push_back(found->second);
  return values;
}

/// Mean of the two in the middle when they are even in number; NaN when there are none.
double median_of(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::vector<Row> kind_rows(const std::string& kind, const std::vector<Figures>& runs) {
  auto errors = values_of(runs, "pair_error_m");
  auto p99 = values_of(runs, "scan_p99_ms");
  const std::string name =
      kind + (runs.size() == 1 ? ", 1 seed" : ", " + std::to_string(runs.size()) + " seeds");
  double cpu_ms = 0;
  for (const auto& run : runs) cpu_ms += run.at("scan_mean_ms") * run.at("scans");
  return {
      {name, "error of pairs seen again, median seed", "m", median_of(errors)},
      {name, "error of pairs seen again, worst seed", "m", percentile(errors, 1)},
      {name, "pairs worse than 0.5 m, all seeds", "%",
       100 * sum_of(runs, "bad_pairs") / sum_of(runs, "pairs")},
      {name, "loops, all seeds", "1", sum_of(runs, "loops")},
      {name, "CPU per scan, mean", "ms", cpu_ms / sum_of(runs, "scans")},
      {name, "CPU per scan, p99, worst seed", "ms", percentile(p99, 1)},
  };
}

/// One drive for each seed from 1 on.
Result<std::vector<Figures>> run_kind(const std::string& kind, int seeds) {
  std::vector<Figures> runs;
  for (int seed = 1; seed <= seeds; ++seed) {
    auto figures = run_part({"world", kind, std::to_string(seed)});
    if (!figures) return tl::unexpected(figures.error());
    say(kind, seed, *figures);
    runs.push_back(*std::move(figures));
  }
  return runs;
}

}  // namespace

Result<std::vector<Row>> world_rows(const MapOptions& options) {
  std::vector<Row> rows;
  for (const auto& kind : world_kinds()) {
    const auto runs = run_kind(kind, options.worlds);
    if (!runs) return tl::unexpected(runs.error());
    const auto more = kind_rows(kind, *runs);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

Result<std::vector<Row>> long_rows(const MapOptions& options) {
  constexpr double kGoalMb = 200;
  const auto runs = run_kind(kLongGrid, options.worlds);
  if (!runs) return tl::unexpected(runs.error());
  auto rows = kind_rows(kLongGrid, *runs);
  auto cpu_s = values_of(*runs, "cpu_s");
  auto peak_mb = values_of(*runs, "peak_mb");
  const std::string name = rows.front().case_name;
  rows.push_back({name, "CPU of the drive, worst seed", "s", percentile(cpu_s, 1)});
  rows.push_back(at_most({name, "peak memory, worst seed", "MB", percentile(peak_mb, 1)}, kGoalMb));
  return rows;
}

int run_world_part(const std::vector<std::string>& tokens) {
  const bool carried = tokens.size() >= 3 && tokens[2] == "carried";
  const std::size_t named = carried ? 3 : 2;
  if (tokens.size() < named || tokens.size() > named + 1) return 2;
  const auto table = tokens.size() > named ? std::optional(tokens.back()) : std::nullopt;
  const auto figures = run_world(tokens[0], std::strtoull(tokens[1].c_str(), nullptr, 10), carried, table);
  if (!figures) {
    std::cerr << figures.error().message << "\n";
    return EXIT_FAILURE;
  }
  std::cout.precision(17);
  for (const auto& [name, value] : *figures) std::cout << name << ' ' << value << '\n';
  return EXIT_SUCCESS;
}

}  // namespace extperfc::benchmark
