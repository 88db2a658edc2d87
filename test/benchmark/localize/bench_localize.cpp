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

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/localize/localizer.hpp"
#include "extperfc/world/map_file.hpp"

#include "test/benchmark/localize/peer.hpp"
#include "test/benchmark/localize/recording.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

using localize::Localizer;
using localize::LocalizerParams;

constexpr char kHelp[] =
    "bench_localize [--quick] [--log FILE] [--trajectory FILE] [--json FILE]\n"
    "Localizes a CARMEN log in a map that is drawn from every second key frame, scored on the others.\n"
    "  --quick            the first 2500 scans only, fewer repetitions\n"
    "  --log FILE         the log; default: Intel's, where it is next to this package\n"
    "  --trajectory FILE  where the robot really was (TUM, a line per scan); default: our mapper's result\n"
    "Peer: MRPT's CMonteCarloLocalization2D (what pf-localization runs) with a likelihood field of the same\n"
    "width and MRPT's default noise of odometry.\n"
    "Times are CPU times of the filter's updates; odometry's 0.2 m or 0.2 rad lie between two of them.\n";
constexpr char kPeerName[] = "MRPT";
constexpr double kUpdate_m = 0.2;
constexpr double kUpdate_rad = 0.2;
constexpr std::size_t kSettled = 50;  // scans that are not scored

struct Options {
  bool quick{false};
  std::filesystem::path log{std::filesystem::path(EXTPERFC_SOURCE_DIR) / "../shared/data/slam/intel.clf.bz2"};
  std::filesystem::path trajectory;
  std::string json;
};

/// A filter under test: ours or the peer's.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual void begin_at(const Pose2& pose) = 0;
  virtual void initialize_globally() = 0;
  virtual void update(const LaserScan& scan, const Pose2& odom) = 0;
  [[nodiscard]] virtual Pose2 pose() const = 0;
};

constexpr double kSigma_m = 0.3;
constexpr double kSigma_rad = 0.2;

class Ours : public Subject {
 public:
  Ours(const std::shared_ptr<const OccupancyGrid>& map, int min_particles, int max_particles)
      : localizer_(make(map, min_particles, max_particles)) {}
  void begin_at(const Pose2& pose) override {
    const Eigen::Vector3d variances(kSigma_m * kSigma_m, kSigma_m * kSigma_m, kSigma_rad * kSigma_rad);
    if (!localizer_.set_pose(pose, variances.asDiagonal())) std::abort();
  }
  void initialize_globally() override { localizer_.initialize_globally(); }
  void update(const LaserScan& scan, const Pose2& odom) override {
    if (!localizer_.update(scan, odom, true)) std::abort();
  }
  [[nodiscard]] Pose2 pose() const override { return localizer_.estimate().pose; }

 private:
  static Localizer make(const std::shared_ptr<const OccupancyGrid>& map, int min_particles,
                        int max_particles) {
    LocalizerParams params;
    params.min_particles = min_particles;
    params.max_particles = max_particles;
    auto made = Localizer::make(params, map);
    if (!made) std::abort();
    return std::move(*made);
  }
  Localizer localizer_;
};

class Theirs : public Subject {
 public:
  explicit Theirs(std::unique_ptr<Peer> peer) : peer_(std::move(peer)) {}
  void begin_at(const Pose2& pose) override {
    peer_->begin_at(pose, kSigma_m, kSigma_rad);
    last_.reset();
  }
  void initialize_globally() override {
    peer_->initialize_globally();
    last_.reset();
  }
  void update(const LaserScan& scan, const Pose2& odom) override {
    peer_->update(scan, last_ ? between(*last_, odom) : Pose2{});
    last_ = odom;
  }
  [[nodiscard]] Pose2 pose() const override { return peer_->pose(); }

 private:
  std::unique_ptr<Peer> peer_;
  std::optional<Pose2> last_;
};

struct Run {
  std::vector<double> ms;  ///< per update
  double mean_m{0};
  double mean_deg{0};
  std::size_t scored{0};
};

bool moved(const Pose2& last, const Pose2& now) {
  const Pose2 motion = between(last, now);
  return std::hypot(motion.x, motion.y) >= kUpdate_m || std::abs(motion.yaw) >= kUpdate_rad;
}

double apart_m(const Pose2& a, const Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}
double apart_deg(const Pose2& a, const Pose2& b) {
  return std::abs(wrap_angle(a.yaw - b.yaw)) * 180 / M_PI;
}

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
    run.mean_m += apart_m(pose, recording.truth[i]);
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
  constexpr double kFound_m = 0.5;
  constexpr double kFound_deg = 12;
  subject.initialize_globally();
  Pose2 last;
  double travelled_m = 0;
  bool found = true;
  for (std::size_t i = start; i < recording.scans.size() && travelled_m < 40; ++i) {
    if (i > start) travelled_m += apart_m(recording.odom[i - 1], recording.odom[i]);
    if (i > start && !moved(last, recording.odom[i])) continue;
    const CpuStopwatch watch;
    subject.update(recording.scans[i], recording.odom[i]);
    ms.push_back(1e3 * watch.seconds());
    last = recording.odom[i];
    if (travelled_m >= 30)
      found = found && apart_m(subject.pose(), recording.truth[i]) < kFound_m &&
              apart_deg(subject.pose(), recording.truth[i]) < kFound_deg;
  }
  return found && travelled_m >= 30;
}

std::unique_ptr<Subject> peer_for(const OccupancyGrid& map, int min_particles, int max_particles) {
  auto peer = Peer::make(map, min_particles, max_particles, 3);  // 180 rays, 60 beams
  if (!peer) return nullptr;
  return std::make_unique<Theirs>(std::move(peer));
}

/// A row with both sides; `peer` may be missing.
Row both(const std::string& name, const std::string& metric, const std::string& unit, double ours,
         std::optional<double> peer) {
  Row row{name, metric, unit, ours};
  if (peer) {
    row.peer = peer;
    row.peer_name = kPeerName;
  }
  return row;
}

template <typename Value>
std::optional<double> of(std::optional<Run>& run, Value value) {
  return run ? std::optional<double>(value(*run)) : std::nullopt;
}

void tracking_rows(const Recording& recording, const std::vector<std::size_t>& frames,
                   const std::shared_ptr<const OccupancyGrid>& map, int particles, std::vector<Row>& rows) {
  Ours ours(map, particles, particles);
  Run mine = track(ours, recording, frames);
  std::optional<Run> other;
  if (const auto peer = peer_for(*map, particles, particles)) other = track(*peer, recording, frames);
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
  Ours ours(map, 500, 10000);
  const auto peer = peer_for(*map, 500, 10000);
  std::vector<double> mine_ms;
  std::vector<double> other_ms;
  int mine = 0;
  int other = 0;
  for (int i = 0; i < starts; ++i) {
    const auto start =
        static_cast<std::size_t>((i + 0.5) / (starts + 1) * static_cast<double>(recording.scans.size()));
    mine += find(ours, recording, start, mine_ms);
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
  const auto map = draw_map(*recording, frames);
  std::vector<Row> rows;
  for (const int particles : {500, 2000, 10000}) tracking_rows(*recording, frames, map, particles, rows);
  global_rows(*recording, map, options.quick ? 2 : 7, rows);
  const auto mib = process_mib(*map, options.log);
  if (!mib) return fail(ErrorCode::kFailed, "bench_localize_process gave no figure");
  rows.push_back(at_most({"separate process, 500 to 10000 particles", "peak memory", "MiB", *mib}, 60));
  return rows;
}

std::optional<Options> parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool value = i + 1 < arguments.size();
    if (arguments[i] == "--quick")
      options.quick = true;
    else if (arguments[i] == "--log" && value)
      options.log = arguments[++i];
    else if (arguments[i] == "--trajectory" && value)
      options.trajectory = arguments[++i];
    else if (arguments[i] == "--json" && value)
      options.json = arguments[++i];
    else
      return std::nullopt;
  }
  return options;
}

int run(const Options& options) {
  std::cout << machine_description() << "\n\n";
  std::vector<Row> rows;
  if (std::filesystem::exists(options.log)) {
    auto measured = measure(options);
    if (!measured) {
      std::cerr << "bench_localize: " << measured.error().message << "\n";
      return EXIT_FAILURE;
    }
    rows = std::move(*measured);
  } else {
    std::cerr << "bench_localize: there is no log " << options.log << "; name one with --log\n";
    return EXIT_FAILURE;
  }
  print_table(std::cout, rows);
  if (options.json.empty() || write_json(options.json, "localize", rows)) return EXIT_SUCCESS;
  std::cerr << "cannot write " << options.json << "\n";
  return EXIT_FAILURE;
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;  // NOLINT
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto options = parse(arguments);
  if (options) return run(*options);
  const bool help = arguments.size() == 1 && (arguments[0] == "--help" || arguments[0] == "-h");
  std::fputs(kHelp, help ? stdout : stderr);
  return help ? EXIT_SUCCESS : 2;
}
