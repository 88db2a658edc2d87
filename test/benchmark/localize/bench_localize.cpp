// The Monte Carlo localizer: time per update, accuracy, global localization, memory. Run with --help.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <unistd.h>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/benchmark/localize/halves_part.hpp"
#include "test/benchmark/localize/recording.hpp"
#include "test/benchmark/localize/rows.hpp"
#include "test/benchmark/localize/subject.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kHelp[] =
    "bench_localize [--quick] [--only PART] [--log FILE] [--trajectory FILE] [--json FILE]\n"
    "               [--logs FOLDER] [--trajectories FOLDER] [--seed N] [--seeds N]\n"
    "Part interleaved: a CARMEN log in a map of every second key frame, scored on the others.\n"
    "Part halves: the logs of three buildings; a map of one half's key frames, localization of the other "
    "half,\n"
    "both directions. Our mapper's trajectory of the whole log is the truth. Poses within 1 m of a mapped "
    "key\n"
    "frame count (known ground); the table says how many. Errors are added to the log's odometry: lengths "
    "wrong\n"
    "by 3 % and a veer of 0.02 rad/m (standard deviations, drawn once a drive), and noise of every scan. "
    "Right\n"
    "means within 0.5 m and 12 degrees; a loss is more than five updates in a row that are not right; "
    "certain\n"
    "means a reported standard deviation of at most 0.2 m. Trials last 30 updates on known ground, 60 of a\n"
    "robot that stands; found means right to the end, for ten updates at least. 20 updates are 10 s of a "
    "robot\n"
    "that stands, 4 m of one that drives. Takes minutes.\n"
    "  --quick            the first 2500 scans only, fewer repetitions, one building\n"
    "  --only PART        interleaved or halves; default: both\n"
    "  --log FILE         of interleaved; default: Intel's, where it is next to this package\n"
    "  --trajectory FILE  its true poses (TUM, a line per scan); default: our mapper's result\n"
    "  --logs FOLDER      of halves: intel, mit-csail and fr079.clf.bz2; default: next to this package\n"
    "  --trajectories FOLDER  their true poses, NAME.tum\n"
    "  --seed N           first seed of the odometry's errors (default 1)\n"
    "  --seeds N          seeds for tracking (default 3)\n"
    "Peer: MRPT's CMonteCarloLocalization2D (what pf-localization runs) with a likelihood field of the same\n"
    "width and MRPT's default noise of odometry. It does not recover from a wrong pose: not kidnapped.\n"
    "Times are CPU times of the filter's updates; odometry's 0.2 m or 0.2 rad lie between two of them.\n";
constexpr char kInterleaved[] = "interleaved";
constexpr char kHalves[] = "halves";
constexpr std::size_t kSettled = 50;  // scans that are not scored

struct Options {
  bool quick{false};
  bool help{false};
  std::string only;
  std::filesystem::path log;
  std::filesystem::path trajectory;
  HalvesOptions halves;
  std::string json;
};

struct Run {
  std::vector<double> ms;  ///< per update
  double mean_m{0};
  double mean_deg{0};
  std::size_t scored{0};
};

/// Scored at the key frames that are not in the map; between updates the pose follows odometry.
Run track(Subject& subject, const Recording& recording, const std::vector<std::size_t>& frames) {
  Run run;
  subject.begin_at(recording.truth[0]);
  Pose2 last;
  std::size_t next = 1;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    if (i == 0 || moved(last, recording.odom[i])) {
      const CpuStopwatch watch;
      subject.update(recording.scans[i], recording.odom[i]);
      run.ms.push_back(1e3 * watch.seconds());
      last = recording.odom[i];
    }
    if (next >= frames.size() || frames[next] != i) continue;
    next += 2;
    if (i < kSettled) continue;
    const Pose2 pose = compose(subject.pose(), between(last, recording.odom[i]));
    run.mean_m += distance_m(pose, recording.truth[i]);
    run.mean_deg += apart_deg(pose, recording.truth[i]);
    ++run.scored;
  }
  run.mean_m /= static_cast<double>(std::max<std::size_t>(run.scored, 1));
  run.mean_deg /= static_cast<double>(std::max<std::size_t>(run.scored, 1));
  return run;
}

/// Found: within 0.5 m and 12 degrees after 30 m travelled, and for all the 10 m after that. Returns CPU ms
/// per update.
bool find(Subject& subject, const Recording& recording, std::size_t start, std::vector<double>& ms) {
  subject.initialize_globally();
  Pose2 last;
  double travelled_m = 0;
  bool found = true;
  for (std::size_t i = start; i < recording.scans.size() && travelled_m < 40; ++i) {
    if (i > start) travelled_m += distance_m(recording.odom[i - 1], recording.odom[i]);
    if (i > start && !moved(last, recording.odom[i])) continue;
    const CpuStopwatch watch;
    subject.update(recording.scans[i], recording.odom[i]);
    ms.push_back(1e3 * watch.seconds());
    last = recording.odom[i];
    if (travelled_m >= 30) found = found && is_right(subject.pose(), recording.truth[i]);
  }
  return found && travelled_m >= 30;
}

template <typename Value>
std::optional<double> of(std::optional<Run>& run, Value value) {
  return run ? std::optional<double>(value(*run)) : std::nullopt;
}

void tracking_rows(const Recording& recording, const std::vector<std::size_t>& frames,
                   const std::shared_ptr<const OccupancyGrid>& map, int particles, std::vector<Row>& rows) {
  localize::LocalizerParams params;
  params.min_particles = params.max_particles = particles;
  Run mine = track(*make_ours(map, params), recording, frames);
  std::optional<Run> other;
  if (const auto peer = make_theirs(*map, particles, particles, recording.scans[0].ranges.size()))
    other = track(*peer, recording, frames);
  const std::string name = std::to_string(particles) + " particles, 60 beams";
  const auto at = [](double fraction) {
    return [fraction](Run& run) { return percentile(run.ms, fraction); };
  };
  Row median = both(name, "CPU per update, median", "ms", at(0.5)(mine), of(other, at(0.5)));
  rows.push_back(particles == 500 ? at_most(median, 1) : particles == 2000 ? at_most(median, 2) : median);
  rows.push_back(both(name, "CPU per update, 99 %", "ms", at(0.99)(mine), of(other, at(0.99))));
  const auto metres = [](Run& run) { return run.mean_m; };
  const auto degrees = [](Run& run) { return run.mean_deg; };
  const Row off = both(name, "mean error of position", "m", metres(mine), of(other, metres));
  const Row turned = both(name, "mean error of heading", "deg", degrees(mine), of(other, degrees));
  rows.push_back(particles == 500 ? at_most(off, 0.05) : off);
  rows.push_back(particles == 500 ? at_most(turned, 1.1) : turned);
}

void global_rows(const Recording& recording, const std::shared_ptr<const OccupancyGrid>& map, int starts,
                 std::vector<Row>& rows) {
  localize::LocalizerParams params;
  params.max_particles = 10000;
  const auto ours = make_ours(map, params);
  const auto peer = make_theirs(*map, 500, 10000, recording.scans[0].ranges.size());
  std::vector<double> mine_ms;
  std::vector<double> other_ms;
  int mine = 0;
  int other = 0;
  for (int i = 0; i < starts; ++i) {
    const auto start =
        static_cast<std::size_t>((i + 0.5) / (starts + 1) * static_cast<double>(recording.scans.size()));
    mine += find(*ours, recording, start, mine_ms);
    if (peer) other += find(*peer, recording, start, other_ms);
  }
  const std::string name = "global, up to 10000 particles";
  const auto theirs = [&](double value) { return peer ? std::optional<double>(value) : std::nullopt; };
  rows.push_back(
      at_least(both(name, "found, of " + std::to_string(starts), "starts", mine, theirs(other)), starts));
  rows.push_back(both(name, "CPU per update, median", "ms", percentile(mine_ms, 0.5),
                      theirs(percentile(other_ms, 0.5))));
  rows.push_back(
      both(name, "CPU per update, longest", "ms", percentile(mine_ms, 1), theirs(percentile(other_ms, 1))));
}

/// Peak memory of a separate process; no value when it fails.
std::optional<double> process_mib(const OccupancyGrid& map, const std::filesystem::path& log) {
  const auto folder =
      std::filesystem::temp_directory_path() /
      ("bench_localize_" + std::to_string(std::hash<std::string>{}(log.string() + std::to_string(getpid()))));
  std::filesystem::create_directories(folder);
  std::optional<double> mib;
  if (save_map(map, folder / "map")) {
    const auto program =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "bench_localize_process";
    const std::string command =
        "'" + program.string() + "' '" + (folder / "map.yaml").string() + "' '" + log.string() + "'";
    if (FILE* pipe = popen(command.c_str(), "r"); pipe != nullptr) {
      double value = 0;
      if (std::fscanf(pipe, "%lf", &value) == 1) mib = value;
      pclose(pipe);
    }
  }
  std::filesystem::remove_all(folder);
  return mib;
}

Result<std::vector<Row>> measure(const Options& options) {
  const auto recording = load_recording(options.log, options.trajectory, options.quick ? 2500 : SIZE_MAX);
  if (!recording) return tl::unexpected(recording.error());
  const auto frames = key_frames(*recording);
  const auto map = draw_map(*recording, every_second(frames));
  std::vector<Row> rows;
  for (const int particles : {500, 2000, 10000}) tracking_rows(*recording, frames, map, particles, rows);
  global_rows(*recording, map, options.quick ? 2 : 7, rows);
  const auto mib = process_mib(*map, options.log);
  if (!mib) return fail(ErrorCode::kFailed, "bench_localize_process gave no figure");
  rows.push_back(at_most({"separate process, 500 to 10000 particles", "peak memory", "MiB", *mib}, 60));
  return rows;
}

Result<int> count_of(const Arguments& arguments, const std::string& option, int by_default) {
  constexpr double kMax = 1e6;
  const auto given = arguments.number(option, 1, kMax);
  if (!given) return tl::unexpected(given.error());
  return static_cast<int>(given->value_or(by_default));
}

Result<Options> parse(const std::vector<std::string>& tokens) {
  const std::filesystem::path logs = std::filesystem::path(EXTPERFC_SOURCE_DIR) / "../shared/data/slam";
  const auto arguments = Arguments::read(
      tokens, {0,
               0,
               {"--only", "--log", "--trajectory", "--logs", "--trajectories", "--seed", "--seeds", "--json"},
               {"--quick", "--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  Options options;
  options.quick = arguments->has("--quick");
  options.help = arguments->has("--help");
  options.only = arguments->last("--only").value_or("");
  if (!options.only.empty() && options.only != kInterleaved && options.only != kHalves)
    return fail(ErrorCode::kInvalidArgument,
                "--only needs interleaved or halves, not '" + options.only + "'");
  options.log = arguments->last("--log").value_or(logs / "intel.clf.bz2");
  options.trajectory = arguments->last("--trajectory").value_or("");
  options.json = arguments->last("--json").value_or("");
  options.halves.logs = arguments->last("--logs").value_or(logs);
  options.halves.trajectories = arguments->last("--trajectories").value_or("");
  const auto seed = count_of(*arguments, "--seed", 1);
  const auto seeds = count_of(*arguments, "--seeds", options.quick ? 1 : options.halves.seeds);
  if (!seed || !seeds) return tl::unexpected(seed ? seeds.error() : seed.error());
  options.halves.first_seed = static_cast<std::uint64_t>(*seed);
  options.halves.seeds = *seeds;
  if (options.quick) options.halves.names = {"mit-csail"};
  return options;
}

Result<std::vector<Row>> measure_all(const Options& options) {
  std::vector<Row> rows;
  if (options.only != kHalves) {
    if (!std::filesystem::exists(options.log))
      return fail(ErrorCode::kNotFound, "there is no log " + options.log.string() + "; name one with --log");
    auto measured = measure(options);
    if (!measured) return measured;
    rows = std::move(*measured);
  }
  if (options.only == kInterleaved) return rows;
  auto halves = halves_rows(options.halves);
  if (!halves) return halves;
  rows.insert(rows.end(), halves->begin(), halves->end());
  return rows;
}

int run(const Options& options) {
  std::cout << machine_description() << "\n\n";
  const auto rows = measure_all(options);
  if (!rows) {
    std::cerr << "bench_localize: " << rows.error().message << "\n";
    return EXIT_FAILURE;
  }
  print_table(std::cout, *rows);
  if (options.json.empty() || write_json(options.json, "localize", *rows)) return EXIT_SUCCESS;
  std::cerr << "cannot write " << options.json << "\n";
  return EXIT_FAILURE;
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;  // NOLINT
  const auto options = parse({argv + 1, argv + argc});
  if (!options) {
    std::cerr << "bench_localize: " << options.error().message << "\n" << kHelp;
    return 2;
  }
  if (!options->help) return run(*options);
  std::fputs(kHelp, stdout);
  return EXIT_SUCCESS;
}
