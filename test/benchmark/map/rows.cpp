#include "test/benchmark/map/rows.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <utility>

#include "test/benchmark/map/child.hpp"
#include "test/benchmark/map/log_part.hpp"
#include "test/benchmark/map/peer.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

constexpr int kParticles = 30;  // of the goals
constexpr int kMaxOtherSeeds = 3;
constexpr double kMapEveryS = 5;  // the nodelet's map_update_interval

// Goals for 30 particles; those of accuracy, CPU time and memory are of the whole Intel log.
constexpr double kGoalTranslationM = 0.018;
constexpr double kGoalRotationDeg = 0.45;
constexpr double kGoalLoopM = 0.15;
constexpr double kGoalCpuS = 60;
constexpr double kGoalP99Ms = 10;
constexpr double kGoalMemoryMb = 80;
constexpr double kGoalPercent = 25;
constexpr double kGoalMapMs = 20;

void say(const std::string& what) {
  std::cerr << what << std::endl;
}

double figure(const Figures& figures, const std::string& name) {
  const auto found = figures.find(name);
  return found == figures.end() ? std::nan("") : found->second;
}

/// Of several seeds.
double worst_of(const std::vector<Figures>& runs, const std::string& name) {
  double worst = figure(runs.front(), name);
  for (const auto& run : runs) worst = std::max(worst, figure(run, name));
  return worst;
}

std::string text(const Figures& figures, const std::string& name) {
  return detail::number(figure(figures, name), "-");
}

double mean_of(const std::vector<Figures>& runs, const std::string& name) {
  double sum = 0;
  for (const auto& run : runs) sum += figure(run, name);
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
    say("  " + subject.name + ", " + std::to_string(particles) + " particles, seed " + std::to_string(seed) +
        ": " + text(*figures, "translation_m") + " m, " + text(*figures, "rotation_deg") + " deg, loop " +
        text(*figures, "worst_loop_m") + " m, " + text(*figures, "cpu_s") + " s, " +
        text(*figures, "peak_mb") + " MB");
    runs.push_back(*std::move(figures));
  }
  return runs;
}

struct Line {
  const char* figure;
  const char* metric;
  const char* unit;
  double goal;       // for 30 particles
  bool whole_intel;  // the goal is of the whole Intel log
};

constexpr Line kLines[] = {
    {"translation_m", "translational error", "m", kGoalTranslationM, true},
    {"rotation_deg", "rotational error", "deg", kGoalRotationDeg, true},
    {"worst_loop_m", "worst loop relation", "m", kGoalLoopM, true},
    {"cpu_s", "CPU of the log", "s", kGoalCpuS, true},
    {"scan_mean_ms", "CPU per scan, mean", "ms", 0, false},
    {"scan_p99_ms", "CPU per scan, p99", "ms", kGoalP99Ms, false},
    {"scan_max_ms", "CPU per scan, largest", "ms", 0, false},
    {"peak_mb", "peak memory", "MB", kGoalMemoryMb, true},
};

/// Worst and, with several seeds and 30 particles, mean of every figure.
std::vector<Row> seed_rows(const std::string& case_name, const std::vector<Figures>& runs, bool goals,
                           bool whole_intel) {
  std::vector<Row> rows;
  for (const Line& line : kLines) {
    const bool several = runs.size() > 1;
    Row row{case_name, std::string(line.metric) + (several ? ", worst seed" : ""), line.unit,
            worst_of(runs, line.figure)};
    const bool has_goal = goals && line.goal > 0 && (whole_intel || !line.whole_intel);
    rows.push_back(has_goal ? at_most(row, line.goal) : row);
    if (several && goals)
      rows.push_back({case_name, std::string(line.metric) + ", mean of " + std::to_string(runs.size()),
                      line.unit, mean_of(runs, line.figure)});
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

std::string with_scans(const Subject& subject, std::size_t scans) {
  return scans == kWholeLog || !subject.is_intel
             ? subject.name
             : subject.name + ", first " + std::to_string(scans) + " scans";
}

}  // namespace

Result<std::vector<Row>> log_rows(const Subject& subject, const MapOptions& options) {
  const bool whole_intel = subject.is_intel && options.scans == kWholeLog;
  const std::string name = with_scans(subject, options.scans);
  std::vector<Row> rows;
  std::map<int, Figures> first;
  for (const int particles : {kParticles, 1, 10, 100}) {
    const bool goals = particles == kParticles;
    const int seeds = goals ? options.seeds : std::min(options.seeds, kMaxOtherSeeds);
    const auto runs = run_seeds(subject, particles, seeds, options.scans);
    if (!runs) return tl::unexpected(runs.error());
    first[particles] = runs->front();
    const auto more =
        seed_rows(name + ", " + std::to_string(particles) + " particles", *runs, goals, whole_intel);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  const auto growth = growth_rows(name + ", growth", first[1], first[kParticles], first[100]);
  rows.insert(rows.end(), growth.begin(), growth.end());
  return rows;
}

Result<std::vector<Row>> peer_rows(const Subject& subject, const MapOptions& options) {
  say("  " + std::string(kPeerName) + " ...");
  const auto peer = run_peer(subject.recording, options.peer_scans);
  if (!peer) return tl::unexpected(peer.error());
  std::vector<Row> rows;
  for (const int particles : {kPeerParticles, kParticles}) {
    if (options.quick && particles != kPeerParticles) continue;
    const auto runs = run_seeds(subject, particles, 1, options.peer_scans);
    if (!runs) return tl::unexpected(runs.error());
    const auto& ours = runs->front();
    const std::string name = with_scans(subject, options.peer_scans) + ", " + std::to_string(particles) +
                             " particles : its " + std::to_string(kPeerParticles);
    const auto add = [&](const char* what, const char* metric, const char* unit) {
      rows.push_back({name, metric, unit, figure(ours, what), figure(*peer, what), kPeerName});
    };
    add("translation_m", "translational error", "m");
    add("rotation_deg", "rotational error", "deg");
    add("worst_loop_m", "worst loop relation", "m");
    add("cpu_s", "CPU of the log", "s");
    rows.push_back({name, "CPU per scan of the log, mean", "ms", 1e3 * ours.at("cpu_s") / ours.at("scans"),
                    1e3 * peer->at("cpu_s") / peer->at("scans"), kPeerName});
    rows.push_back({name, "CPU per filter step, mean", "ms", 1e3 * ours.at("cpu_s") / ours.at("key_frames"),
                    1e3 * peer->at("cpu_s") / peer->at("filter_steps"), kPeerName});
    add("peak_mb", "peak memory", "MB");
  }
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
    const auto runs = run_seeds({name, false, *office}, kParticles, 1, kWholeLog);
    if (!runs) return tl::unexpected(runs.error());
    const Figures& run = runs->front();
    // CPU seconds of mapping per second of the drive
    const Row load{name, "CPU, load of a core", "%", 0.1 * run.at("scan_mean_ms") * one.rate_hz};
    const bool has_goal = one.rays == 360 && one.rate_hz == 10;
    rows.push_back(has_goal ? at_most(load, kGoalPercent) : load);
    rows.push_back({name, "CPU per scan, p99", "ms", run.at("scan_p99_ms")});
    rows.push_back({name, "translational error", "m", run.at("translation_m")});
    rows.push_back({name, "worst loop relation", "m", figure(run, "worst_loop_m")});
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
    rows.push_back(at_most({cells, "map(), worst call", "ms", figure(*figures, "map_max_ms")}, kGoalMapMs));
    rows.push_back(
        {cells, "map(), median of the last quarter", "ms", figure(*figures, "map_last_median_ms")});
    rows.push_back({cells, "peak memory", "MB", figures->at("peak_mb")});
    rows.push_back({cells, "memory per explored area", "B/m^2",
                    1e6 * (figures->at("peak_mb") - figures->at("base_mb")) / figures->at("explored_m2")});
    rows.push_back({cells, "CPU per scan, p99", "ms", figures->at("scan_p99_ms")});
  }
  return rows;
}

}  // namespace extperfc::benchmark
