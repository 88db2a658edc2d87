#include <csignal>
#include <iostream>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/offline/image.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/offline/placed_scans.hpp"
#include "extperfc/sources/mrpt_map.hpp"
#include "extperfc/world/map_file.hpp"

#include "offline/tool/map_options.hpp"
#include "offline/tool/map_report.hpp"
#include "offline/tool/program.hpp"
#include "offline/tool/progress_line.hpp"

namespace extperfc::offline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = "extperfc-map";

volatile std::sig_atomic_t stop_wanted = 0;

/// The first signal asks to stop; the next one finds the system's own answer.
extern "C" void ask_to_stop(int signal) {
  stop_wanted = 1;
  (void)std::signal(signal, SIG_DFL);
}

Result<mapping::Mapper> make_mapper(const MapOptions& options) {
  if (!options.session) return mapping::Mapper::make(options.params);
  auto mapper = mapping::Mapper::load(*options.session, options.params);
  if (!mapper || !options.start_pose) return mapper;
  constexpr double kStartM = 0.5;
  constexpr double kStartRad = 0.25;
  const Eigen::Vector3d variances(kStartM * kStartM, kStartM * kStartM, kStartRad * kStartRad);
  if (auto put = mapper->put_at(*options.start_pose, variances.asDiagonal()); !put)
    return tl::unexpected(put.error());
  return mapper;
}

MappingResult run(const MapOptions& options, sources::ScanLog& log, mapping::Mapper& mapper) {
  ProgressLine line;
  MappingOptions mapping;
  mapping.use_odometry = options.use_odometry;
  mapping.max_scans = options.max_scans;
  mapping.should_continue = [&](const MappingProgress& progress) {
    if (!options.quiet) line.show(progress);
    return stop_wanted == 0;
  };
  auto result = map_recording(log, mapper, mapping);
  line.end();
  return result;
}

/// Adds the sessions. The trajectory is then of all scans: of the map so far, and of the sessions in their
/// order.
Result<void> merge(const MapOptions& options, mapping::Mapper& mapper, MappingResult& result) {
  const Stopwatch wall;
  const double start_s = process_cpu_seconds();
  for (const fs::path& session : options.merged) {
    if (stop_wanted != 0) return fail(ErrorCode::kFailed, "interrupted before " + session.string());
    if (!options.quiet) std::cerr << "merging " << session.string() << std::endl;
    if (auto merged = mapper.merge(session); !merged) return merged;
  }
  result.trajectory = mapper.trajectory();
  result.scan_index.resize(result.trajectory.size());
  std::iota(result.scan_index.begin(), result.scan_index.end(), 0);
  result.cpu_s += process_cpu_seconds() - start_s;
  result.wall_s += wall.seconds();
  return {};
}

/// Reads the recording again for a simple map, as only this output needs the scans.
Result<void> write_mrpt_files(const MapOptions& options, const MappingResult& result,
                              const OccupancyGrid& map) {
  if (options.gridmap)
    if (auto done = sources::save_gridmap(map, *options.gridmap); !done) return done;
  if (!options.simplemap) return {};
  auto log = open_recording(options.recording, options.reading);
  if (!log) return tl::unexpected(log.error());
  const ScanSpacing spacing{options.params.linear_update_m, options.params.angular_update_rad};
  return sources::save_simplemap(placed_scans(**log, result, spacing), *options.simplemap);
}

/// Everything but the reports.
Result<void> write_files(const MapOptions& options, const MappingResult& result,
                         const mapping::Mapper& mapper, const OccupancyGrid& map) {
  if (auto done = write_tum(result.trajectory, options.out / "trajectory.tum"); !done) return done;
  if (auto done = mapper.save(options.out / "map.session"); !done) return done;
  if (auto done = save_map(map, options.out / "map"); !done) return done;
  if (auto done = write_mrpt_files(options, result, map); !done) return done;
  return write_png(draw_map(map, result.trajectory), options.out / "map.png");
}

/// Poses by the scans' numbers in the recording.
std::vector<std::optional<Pose2>> by_index(const MappingResult& result) {
  std::vector<std::optional<Pose2>> poses;
  for (std::size_t i = 0; i < result.trajectory.size(); ++i) {
    if (poses.size() <= result.scan_index[i]) poses.resize(result.scan_index[i] + 1);
    poses[result.scan_index[i]] = result.trajectory[i].pose;
  }
  return poses;
}

Result<int> write_reports(const MapReport& report) {
  const std::string text = report_text(report);
  const std::string json = report_json(report);
  if (auto done = write_text_atomically(report.options.out / "report.txt", text); !done)
    return tl::unexpected(done.error());
  if (auto done = write_text_atomically(report.options.out / "report.json", json); !done)
    return tl::unexpected(done.error());
  std::cout << (report.options.json ? json : text) << std::flush;
  if (!report.options.json) std::cout << "written to   " << report.options.out.string() << '\n' << std::flush;
  if (report.result.broken.empty()) return kDone;
  return fail(ErrorCode::kCorrupt, report.result.broken + "; the map holds what came before");
}

Result<MappingResult> map_log(const MapOptions& options, mapping::Mapper& mapper) {
  auto log = open_recording(options.recording, options.reading);
  if (!log) return tl::unexpected(log.error());
  auto result = run(options, **log, mapper);
  if (result.scans > result.refused) return result;
  return fail(ErrorCode::kCorrupt, options.recording.string() + " holds no usable laser scans" +
                                       (result.broken.empty() ? "" : ": " + result.broken) +
                                       (result.complaints.empty() ? "" : "; " + result.complaints[0]));
}

Result<int> map(const MapOptions& options) {
  MapReport report{options, {}, {}, 0, 0, 0, {}, {}};
  if (options.relations) {
    auto relations = read_relations(*options.relations);
    if (!relations) return tl::unexpected(relations.error());
    report.relations = *std::move(relations);
  }
  auto mapper = make_mapper(options);
  if (!mapper) return tl::unexpected(mapper.error());
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error)
    return fail(ErrorCode::kFailed,
                "cannot make the folder " + options.out.string() + ": " + error.message());
  report.result.base_T_scanner = options.reading.log.base_T_sensor.value_or(Pose2{});  // of sessions alone
  if (!options.recording.empty()) {
    auto result = map_log(options, *mapper);
    if (!result) return tl::unexpected(result.error());
    report.result = *std::move(result);
  }
  if (!options.merged.empty())
    if (auto merged = merge(options, *mapper, report.result); !merged) return tl::unexpected(merged.error());
  const auto grid = mapper->map();
  report.statistics = mapper->statistics();
  report.map_width = grid->width;
  report.map_height = grid->height;
  report.peak_memory_mb = peak_memory_mb();
  if (options.relations)
    report.score = score_relations(report.relations, by_index(report.result), {report.result.base_T_scanner});
  if (auto written = write_files(options, report.result, *mapper, *grid); !written)
    return tl::unexpected(written.error());
  return write_reports(report);
}

int run_tool(const std::vector<std::string>& tokens) {
  const auto options = read_map_options(tokens);
  if (!options) return complain(kProgram, options.error().message, kUsage);
  if (options->help) {
    std::cout << map_help();
    return kDone;
  }
  (void)std::signal(SIGINT, ask_to_stop);
  (void)std::signal(SIGTERM, ask_to_stop);
  const auto done = map(*options);
  return done ? *done : complain(kProgram, done.error().message);
}

}  // namespace
}  // namespace extperfc::offline

int main(int argc, char** argv) {
  using namespace extperfc::offline;  // NOLINT: a program, not a header
  return run_program(kProgram, argc, argv, run_tool);
}
