#include "test/benchmark/map/rows.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/log_part.hpp"
#include "test/benchmark/map/score.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

constexpr int kParticles = 30;  // of the goals
constexpr int kMaxOtherSeeds = 3;
constexpr double kMapEveryS = 5;  // the nodelet's map_update_interval

// Goals for 30 particles and every seed; those of loops, CPU time and memory are of whole logs.
constexpr double kGoalLoopM = 0.15;
constexpr double kGoalCpuS = 60;
constexpr double kGoalP99Ms = 10;
constexpr double kGoalMemoryMb = 80;
constexpr double kGoalPercent = 25;
constexpr double kGoalMapMs = 20;

/// Of several seeds.
double worst_of(const std::vector<Figures>& runs, const std::string& name) {
  double worst = figure_of(runs.front(), name);
  for (const auto& run : runs) worst = std::max(worst, figure_of(run, name));
  return worst;
}

void append(std::vector<Row>& rows, const std::vector<Row>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

double mean_of(const std::vector<Figures>& runs, const std::string& name) {
  double sum = 0;
  for (const auto& run : runs) sum += figure_of(run, name);
  return sum / static_cast<double>(runs.size());
}

Result<std::vector<Figures>> run_seeds(const Subject& subject, int particles, int seeds, std::size_t scans) {
  std::vector<Figures> runs;
  for (int seed = 1; seed <= seeds; ++seed) {
    LogRun run;
    run.recording = subject.recording;
    run.particles = particles;
    run.seed = static_cast<std::uint64_t>(seed);
    run.scans = scans;
    auto figures = run_log(run);
    if (!figures) return tl::unexpected(figures.error());
    std::cerr << "  " << subject.name << ", " << particles << " particles, seed " << seed << ": "
              << summary(*figures) << std::endl;
    runs.push_back(*std::move(figures));
  }
  return runs;
}

struct Line {
  const char* figure;
  const char* metric;
  const char* unit;
  double goal;  // for 30 particles; 0: none
  bool whole;   // the goal is of a whole log
};

std::vector<Line> lines_of(const AccuracyGoals& goals) {
  return {
      {"translation_m", "translational error", "m", goals.translation_m, true},
      {"rotation_deg", "rotational error", "deg", goals.rotation_deg, true},
      {"worst_loop_m", "worst loop relation", "m", kGoalLoopM, true},
      {"cpu_s", "CPU of the log", "s", kGoalCpuS, true},
      {"scan_mean_ms", "CPU per scan, mean", "ms", 0, false},
      {"scan_p99_ms", "CPU per scan, p99", "ms", kGoalP99Ms, false},
      {"scan_max_ms", "CPU per scan, largest", "ms", 0, false},
      {"peak_mb", "peak memory", "MB", kGoalMemoryMb, true},
  };
}

/// The worst of every figure and, with several seeds and 30 particles, the mean.
std::vector<Row> seed_rows(const Subject& subject, int particles, const std::vector<Figures>& runs,
                           std::size_t scans) {
  const std::string name = with_scans(subject, scans) + ", " + std::to_string(particles) + " particles";
  const bool goals = particles == kParticles;
  const bool several = runs.size() > 1;
  const bool whole = subject.goals && scans == kWholeLog;
  std::vector<Row> rows;
  for (const Line& line : lines_of(subject.goals.value_or(AccuracyGoals{}))) {
    const Row row{name, std::string(line.metric) + (several ? ", worst seed" : ""), line.unit,
                  worst_of(runs, line.figure)};
    const bool has_goal = goals && line.goal > 0 && (whole || !line.whole);
    rows.push_back(has_goal ? at_most(row, line.goal) : row);
    if (several && goals)
      rows.push_back({name, std::string(line.metric) + ", mean of " + std::to_string(runs.size()), line.unit,
                      mean_of(runs, line.figure)});
  }
  return rows;
}

std::vector<Row> growth_rows(const std::string& name, const Figures& one, const Figures& thirty,
                             const Figures& hundred) {
  const double grown_bytes = 1e6 * (thirty.at("peak_mb") - thirty.at("base_mb"));
  return {
      {name, "CPU per scan, first quarter", "ms", thirty.at("first_quarter_ms")},
      {name, "CPU per scan, last quarter", "ms", thirty.at("last_quarter_ms")},
      {name, "key frames", "1", thirty.at("key_frames")},
      {name, "explored", "m^2", thirty.at("explored_m2")},
      {name, "memory per explored area", "B/m^2", grown_bytes / thirty.at("explored_m2")},
      {name, "peak memory, 100 particles : 1", "1", hundred.at("peak_mb") / one.at("peak_mb")},
      {name, "CPU, 100 particles : 1", "1", hundred.at("cpu_s") / one.at("cpu_s")},
  };
}

/// The same log with other numbers of particles. `thirty` is a run with 30.
Result<std::vector<Row>> particle_rows(const Subject& subject, const Figures& thirty,
                                       const MapOptions& options) {
  std::vector<Row> rows;
  std::map<int, Figures> first{{kParticles, thirty}};
  for (const int particles : {1, 10, 100}) {
    const auto runs = run_seeds(subject, particles, std::min(options.seeds, kMaxOtherSeeds), options.scans);
    if (!runs) return tl::unexpected(runs.error());
    first[particles] = runs->front();
    append(rows, seed_rows(subject, particles, *runs, options.scans));
  }
  append(rows, growth_rows(with_scans(subject, options.scans) + ", growth", first[1], first[kParticles],
                           first[100]));
  return rows;
}

}  // namespace

Result<std::vector<Row>> log_rows(const std::vector<Subject>& subjects, const MapOptions& options) {
  std::vector<Row> rows;
  std::optional<Figures> first;
  for (const auto& subject : subjects) {
    const auto runs = run_seeds(subject, kParticles, options.seeds, options.scans);
    if (!runs) return tl::unexpected(runs.error());
    if (!first) first = runs->front();
    append(rows, seed_rows(subject, kParticles, *runs, options.scans));
  }
  auto particles = particle_rows(subjects.front(), *first, options);
  if (!particles) return particles;
  append(rows, *particles);
  return rows;
}

Result<std::vector<Row>> rate_rows(const MapOptions& options) {
  struct Case {
    std::size_t rays;
    double rate_hz;
    bool quick;
  };
  constexpr Case kCases[] = {{180, 10, false}, {360, 10, true},  {720, 10, false}, {1440, 10, false},
                             {360, 5, false},  {360, 20, false}, {360, 40, false}};
  std::vector<Row> rows;
  for (const Case& one : kCases) {
    if (options.quick && !one.quick) continue;
    const TemporaryFolder folder;
    const auto office = record_office({one.rays, one.rate_hz, options.drive_s}, folder.path());
    if (!office) return tl::unexpected(office.error());
    const std::string name = "office, " + std::to_string(one.rays) + " rays at " +
                             std::to_string(static_cast<int>(one.rate_hz)) + " Hz, 30 particles";
    const auto runs = run_seeds({name, *office, std::nullopt}, kParticles, 1, kWholeLog);
    if (!runs) return tl::unexpected(runs.error());
    const Figures& run = runs->front();
    // CPU seconds of mapping per second of the drive
    const Row load{name, "CPU, load of a core", "%", 0.1 * run.at("scan_mean_ms") * one.rate_hz};
    const bool has_goal = one.rays == 360 && one.rate_hz == 10;
    rows.push_back(has_goal ? at_most(load, kGoalPercent) : load);
    rows.push_back({name, "CPU per scan, p99", "ms", run.at("scan_p99_ms")});
    rows.push_back({name, "translational error", "m", run.at("translation_m")});
    rows.push_back({name, "worst loop relation", "m", figure_of(run, "worst_loop_m")});
  }
  return rows;
}

Result<std::vector<Row>> map_call_rows(const Subject& subject, const MapOptions& options) {
  const TemporaryFolder folder;
  const auto hall = record_hall(folder.path());
  if (!hall) return tl::unexpected(hall.error());
  LogRun on_log{subject.recording, kParticles, 1, options.scans, kMapEveryS};
  LogRun in_hall{*hall, 1, 1, kWholeLog, kMapEveryS, 2.0, false};
  std::vector<Row> rows;
  for (const auto& [name, run] : {std::pair(with_scans(subject, options.scans), on_log), {"hall", in_hall}}) {
    const auto figures = run_log(run);
    if (!figures) return tl::unexpected(figures.error());
    const std::string cells =
        name + ", " + std::to_string(static_cast<long>(std::lround(figures->at("map_cells")))) + " cells";
    rows.push_back(
        at_most({cells, "map(), worst call", "ms", figure_of(*figures, "map_max_ms")}, kGoalMapMs));
    rows.push_back(
        {cells, "map(), median of the last quarter", "ms", figure_of(*figures, "map_last_median_ms")});
    rows.push_back({cells, "peak memory", "MB", figures->at("peak_mb")});
    rows.push_back({cells, "memory per explored area", "B/m^2",
                    1e6 * (figures->at("peak_mb") - figures->at("base_mb")) / figures->at("explored_m2")});
    rows.push_back({cells, "CPU per scan, p99", "ms", figures->at("scan_p99_ms")});
  }
  return rows;
}

}  // namespace extperfc::benchmark
