#include "test/benchmark/map/peer.hpp"

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/offline/relations.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr char kConfiguration[] =
    "/usr/share/mrpt/config_files/rbpf-slam/gridmapping_RBPF_ICPbased_intel.ini";
constexpr char kSection[] = "[MappingApplication]";

/// The shipped configuration with some keys of its main section set.
Result<void> configure(const std::map<std::string, std::string>& set, const fs::path& to) {
  std::ifstream in(kConfiguration);
  if (!in)
    return fail(ErrorCode::kNotFound,
                std::string(kConfiguration) + " is missing (Debian package mrpt-common)");
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

/// Which scans moved the filter: its output says "New pose" once for each, before the end of the step.
std::vector<std::size_t> filter_steps(const fs::path& output) {
  std::vector<std::size_t> steps;
  std::ifstream in(output);
  bool moved = false;
  std::size_t scan = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.find("] New pose=") != std::string::npos) moved = true;
    if (line.find("---- STEP ") == std::string::npos) continue;
    if (moved) steps.push_back(scan);
    moved = false;
    ++scan;
  }
  return steps;
}

/// A pose for each scan of `steps`, stamped with the scan's number. The first pose of the file is the start.
Result<Trajectory> read_path(const fs::path& file, const std::vector<std::size_t>& steps) {
  std::ifstream in(file);
  Trajectory path;
  StampedPose2 pose;
  for (double yaw = 0; in >> pose.pose.x >> pose.pose.y >> yaw;) {
    pose.pose.yaw = yaw;
    path.push_back(pose);
  }
  if (path.size() != steps.size() + 1)
    return fail(ErrorCode::kCorrupt, "rbpf-slam wrote a path of " + std::to_string(path.size()) +
                                         " poses for " + std::to_string(steps.size()) + " filter steps");
  path.erase(path.begin());
  for (std::size_t i = 0; i < steps.size(); ++i) path[i].stamp_s = static_cast<double>(steps[i]);
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

Result<void> add_score(const Recording& recording, const std::vector<offline::ScanMoment>& moments,
                       const Trajectory& path, Figures& figures) {
  const auto relations = offline::read_relations(recording.relations);
  if (!relations) return tl::unexpected(relations.error());
  const auto poses = offline::poses_of_scans(path, moments);
  if (!poses) return tl::unexpected(poses.error());
  const auto score = offline::score_relations(*relations, *poses);
  figures["relations"] = static_cast<double>(score.all.relations);
  figures["translation_m"] = score.all.translation_m.mean;
  figures["rotation_deg"] = score.all.rotation_deg.mean;
  if (score.loops.relations > 0) figures["worst_loop_m"] = score.loops.translation_m.worst;
  return {};
}

}  // namespace

Result<Figures> run_peer(const Recording& recording, std::size_t scans) {
  const TemporaryFolder folder;
  const auto rawlog = folder.path() / "log.rawlog";
  const auto output = folder.path() / "output";
  const auto written = run_program({beside_this_program("bench_map_rawlog").string(), recording.log.string(),
                                    rawlog.string(), std::to_string(scans)},
                                   output);
  if (!written) return tl::unexpected(written.error());
  const auto results = folder.path() / "results";
  const std::map<std::string, std::string> settings{{"logOutput_dir", results.string()},
                                                    {"LOG_FREQUENCY", "0"},
                                                    {"SAVE_MAP_IMAGES", "0"},
                                                    {"SAVE_3D_SCENE", "0"},
                                                    {"SHOW_PROGRESS_IN_WINDOW", "0"},
                                                    {"RANDOM_SEED", "1"}};
  const auto configuration = folder.path() / "rbpf.ini";
  if (auto done = configure(settings, configuration); !done) return tl::unexpected(done.error());
  const auto run = run_program({"rbpf-slam", configuration.string(), rawlog.string()}, output);
  if (!run) return tl::unexpected(run.error());
  const auto moments = moments_of(recording.log, scans);
  if (!moments) return tl::unexpected(moments.error());
  const auto steps = filter_steps(output);
  const auto path = read_path(results / "most_likely_path.txt", steps);
  if (!path) return tl::unexpected(path.error());
  Figures figures{{"cpu_s", run->cpu_s},
                  {"peak_mb", run->peak_memory_mb},
                  {"scans", static_cast<double>(moments->size())},
                  {"filter_steps", static_cast<double>(steps.size())}};
  if (auto scored = add_score(recording, *moments, *path, figures); !scored)
    return tl::unexpected(scored.error());
  return figures;
}

}  // namespace extperfc::benchmark
