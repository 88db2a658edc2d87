#include "test/benchmark/map/peer.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "extperfc/offline/relations.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "test/benchmark/map/score.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr char kConfigurations[] = "/usr/share/mrpt/config_files";
constexpr char kSection[] = "[MappingApplication]";
constexpr unsigned kMaxCpuS = 600;
constexpr double kShorten = 0.95;  // of what a run did within the limit: the next one must not reach it
constexpr int kMaxRuns = 3;

/// The shipped configuration with some keys of its main section set.
Result<void> configure(const fs::path& shipped, const std::map<std::string, std::string>& set,
                       const fs::path& to) {
  std::ifstream in(shipped);
  if (!in) return fail(ErrorCode::kNotFound, shipped.string() + " is missing (Debian package mrpt-common)");
  std::ofstream out(to);
  for (std::string line; std::getline(in, line);) {
    const auto name = line.substr(0, line.find_first_of("= \t\r"));
    if (set.count(name) == 0) out << line << '\n';
    if (line.rfind(kSection, 0) == 0)
      for (const auto& [key, value] : set) out << key << '=' << value << '\n';
  }
  if (!out) return fail(ErrorCode::kFailed, "cannot write " + to.string());
  return {};
}

std::map<std::string, std::string> settings(const fs::path& results) {
  return {{"logOutput_dir", results.string()},
          {"LOG_FREQUENCY", "0"},
          {"SAVE_MAP_IMAGES", "0"},
          {"SAVE_3D_SCENE", "0"},
          {"SAVE_POSE_LOG", "0"},
          {"CAMERA_3DSCENE_FOLLOWS_ROBOT", "0"},
          {"SHOW_PROGRESS_IN_WINDOW", "0"},     // of rbpf-slam
          {"SHOW_PROGRESS_3D_REAL_TIME", "0"},  // of icp-slam
          {"verbosity_level", "DEBUG"},         // rbpf-slam says which scans moved the filter
          {"RANDOM_SEED", "1"}};
}

/// A program's output, scan by scan.
struct Progress {
  std::size_t scans{0};            // that it has done
  std::vector<std::size_t> steps;  // scans that moved rbpf-slam's filter
};

/// rbpf-slam says "New pose" once for each scan that moves the filter, before the end of the scan's step.
Progress progress_of(const fs::path& output) {
  Progress progress;
  std::ifstream in(output);
  bool moved = false;
  for (std::string line; std::getline(in, line);) {
    if (line.find("] New pose=") != std::string::npos) moved = true;
    if (line.find("---- STEP ") == std::string::npos) continue;
    if (moved) progress.steps.push_back(progress.scans);
    moved = false;
    ++progress.scans;
  }
  return progress;
}

bool is_filter(const PeerProgram& peer) {
  return std::string(peer.program) == "rbpf-slam";
}

/// A pose for each scan that moved the filter, stamped with the scan's number. The first pose of the file is
/// the start.
Result<Trajectory> read_filter_path(const fs::path& file, const std::vector<std::size_t>& steps) {
  std::ifstream in(file);
  Trajectory path;
  for (Pose2 pose; in >> pose.x >> pose.y >> pose.yaw;) path.push_back({0, pose});
  if (path.size() != steps.size() + 1)
    return fail(ErrorCode::kCorrupt, "rbpf-slam wrote a path of " + std::to_string(path.size()) +
                                         " poses for " + std::to_string(steps.size()) + " filter steps");
  path.erase(path.begin());
  for (std::size_t i = 0; i < steps.size(); ++i) path[i].stamp_s = static_cast<double>(steps[i]);
  return path;
}

/// Lines `scan x y yaw`.
Trajectory read_numbered_path(const fs::path& file) {
  std::ifstream in(file);
  Trajectory path;
  StampedPose2 one;
  while (in >> one.stamp_s >> one.pose.x >> one.pose.y >> one.pose.yaw) path.push_back(one);
  return path;
}

/// Numbers instead of stamps: those may run backwards.
Result<std::vector<offline::ScanMoment>> moments_of(const fs::path& file, std::size_t scans) {
  auto log = sources::open_carmen_log(file);
  if (!log) return tl::unexpected(log.error());
  std::vector<offline::ScanMoment> moments;
  while (moments.size() < scans) {
    auto record = (*log)->next();
    if (!record) return tl::unexpected(record.error());
    if (!*record) break;
    moments.push_back({moments.size(), static_cast<double>(moments.size()), (*record)->odom_T_base});
  }
  return moments;
}

/// The program over the first scans, in a folder.
struct Attempt {
  const PeerProgram& peer;
  const Recording& recording;
  std::size_t scans;
  fs::path folder;

  [[nodiscard]] fs::path output() const { return folder / "output"; }
  [[nodiscard]] fs::path results() const { return folder / "results"; }
  [[nodiscard]] Result<ChildRun> run() const;
  [[nodiscard]] Result<Figures> score(const ChildRun& run) const;
};

Result<ChildRun> Attempt::run() const {
  const auto rawlog = folder / "log.rawlog";
  const auto written = run_program({beside_this_program("bench_map_rawlog").string(), recording.log.string(),
                                    rawlog.string(), std::to_string(scans)},
                                   output());
  if (!written) return tl::unexpected(written.error());
  const auto configuration = folder / "configuration.ini";
  if (auto done =
          configure(fs::path(kConfigurations) / peer.configuration, settings(results()), configuration);
      !done)
    return tl::unexpected(done.error());
  return run_program({peer.program, configuration.string(), rawlog.string()}, output(), kMaxCpuS);
}

Result<Figures> Attempt::score(const ChildRun& run) const {
  const auto moments = moments_of(recording.log, scans);
  if (!moments) return tl::unexpected(moments.error());
  Figures figures{{"cpu_s", run.cpu_s}, {"peak_mb", run.peak_memory_mb}};
  Result<Trajectory> path = read_numbered_path(results() / "log_estimated_path.txt");
  if (is_filter(peer)) {
    const auto steps = progress_of(output()).steps;
    figures["filter_steps"] = static_cast<double>(steps.size());
    path = read_filter_path(results() / "most_likely_path.txt", steps);
    if (!path) return tl::unexpected(path.error());
  }
  if (path->empty()) return fail(ErrorCode::kFailed, std::string(peer.program) + " wrote no path");
  const auto poses = offline::poses_of_scans(*path, *moments);
  if (!poses) return tl::unexpected(poses.error());
  if (auto scored = add_score(recording, *poses, figures); !scored) return tl::unexpected(scored.error());
  return figures;
}

}  // namespace

const std::vector<PeerProgram>& peer_programs() {
  static const std::vector<PeerProgram> programs{
      {"MRPT rbpf-slam, ICP", "rbpf-slam", "rbpf-slam/gridmapping_RBPF_ICPbased_intel.ini"},
      {"MRPT rbpf-slam, ICP on grids", "rbpf-slam", "rbpf-slam/gridmapping_RBPF_grid_ICPbased_malaga.ini"},
      {"MRPT rbpf-slam, optimal sampling", "rbpf-slam", "rbpf-slam/gridmapping_optimal_sampling.ini"},
      {"MRPT icp-slam", "icp-slam", "icp-slam/icp-slam_demo_LM.ini"},
  };
  return programs;
}

Result<PeerRun> run_peer(const PeerProgram& peer, const Recording& recording, std::size_t scans) {
  for (int i = 0; i < kMaxRuns; ++i) {
    const TemporaryFolder folder;
    const Attempt part{peer, recording, scans, folder.path()};
    const auto run = part.run();
    if (!run) return tl::unexpected(run.error());
    if (!run->out_of_cpu) {
      auto figures = part.score(*run);
      if (!figures) return tl::unexpected(figures.error());
      return PeerRun{scans, *std::move(figures)};
    }
    const auto done = static_cast<double>(progress_of(part.output()).scans);
    scans = static_cast<std::size_t>(kShorten * done);
  }
  return fail(ErrorCode::kFailed, std::string(peer.program) + " does not end within " +
                                      std::to_string(kMaxCpuS) + " s of CPU over a part that it did before");
}

Result<Figures> run_odometry(const Recording& recording, std::size_t scans) {
  const auto moments = moments_of(recording.log, scans);
  if (!moments) return tl::unexpected(moments.error());
  std::vector<std::optional<Pose2>> poses;
  for (const auto& moment : *moments) poses.push_back(moment.odom_T_base);
  Figures figures;
  if (auto scored = add_score(recording, poses, figures); !scored) return tl::unexpected(scored.error());
  return figures;
}

}  // namespace extperfc::benchmark
