#include "offline/tool/map_options.hpp"

#include <sstream>

#include "extperfc/base/arguments.hpp"
#include "extperfc/mapping/param_names.hpp"

#include "offline/tool/recording_options.hpp"

namespace extperfc::offline {

namespace {

constexpr const char* kHelp = R"(Makes a map of a recording of planar laser scans, without ROS running.

  extperfc-map RECORDING [OPTION ...]
  extperfc-map --continue SESSION --merge SESSION [OPTION ...]

RECORDING is a CARMEN log (FLASER or ROBOTLASER1 lines; plain, .gz or .bz2), a ROS bag with sensor_msgs/LaserScan (and
tf or nav_msgs/Odometry), or an MRPT rawlog. The format is recognised by content. Scans are taken in the order of the
file.

Writes into a folder:
  map.pgm, map.yaml   the map, as map_server, the localizer and amcl read it
  map.png             the same as an image with the path: from blue (green disc) to red (red disc)
  trajectory.tum      a line `stamp x y z qx qy qz qw` for every scan, in the recording's order
  map.session         state to resume mapping: --continue, or the nodelet's service load_session
  report.txt, .json   scans, key frames, loops, CPU time, memory, and the score of --relations

Ctrl-C ends early and writes the results so far; a second one ends at once.

Options:
  --out DIR              the folder, made if it is not there; NAME-map in the present folder by default
  --particles N          hypotheses of the path
  --seed N               of every random draw: the same recording, parameters and seed give the same map
  --resolution M         side of a map's cell [m]
  --set NAME=VALUE       any parameter of the table below; may be given several times
  --relations FILE       scores the trajectory, see extperfc-relations
  --continue SESSION     resumes the map of an earlier run, where that one ended or at --start-pose. A robot that stands
                         elsewhere begins a new part of the map, which is joined when it recognizes a place
  --start-pose X,Y,YAW   with --continue: where the recording begins in that map [m, m, rad], within 1 m and 0.5 rad
  --merge SESSION        adds another session by the places that both show; may be given several times. With --continue
                         no RECORDING is needed
  --gridmap FILE         the map as MRPT's COccupancyGridMap2D, too; packed when the name ends with .gz
  --simplemap FILE       poses and scans as MRPT's CSimpleMap, too; a scan for every key frame's distance
  --scans N              only the first N scans
  --no-odometry          by scan matching alone
  --laser-pose X,Y,YAW   pose of the scanner on the robot [m, m, rad]; overrides the recording. The score of sessions
                         that are merged without a recording needs it
  --sensor-max M         ranges from here on are no return [m]; default: of the recording, 81.8 for FLASER
  --sensor LABEL         rawlogs: the scanner, when there are several; the first one seen by default
  --scan-topic TOPIC     bags: the only topic with laser scans by default
  --odom-topic TOPIC     bags: nav_msgs/Odometry; by default tf, else the only topic with odometry
  --base-frame FRAME     bags: the robot in tf, base_link by default
  --odom-frame FRAME     bags: odometry's frame in tf, odom by default
  --json                 the report as JSON on standard output
  --quiet                no progress on standard error

Parameters for --set, the same as the nodelet's (GMapping's names where the meaning is the same):
)";

constexpr const char* kHelpEnd = R"(
Examples:
  extperfc-map intel.clf.bz2 --out intel --particles 30 --relations intel.relations
  extperfc-map --continue monday/map.session --merge tuesday/map.session --out both

Exit status: 0 done, 1 failed (reason on standard error), 2 wrong usage.
)";

/// What fits together.
Result<void> check(const MapOptions& options) {
  if (options.start_pose && !options.session)
    return fail(ErrorCode::kInvalidArgument, "--start-pose needs --continue");
  if (!options.recording.empty()) return {};
  if (!options.session || options.merged.empty())
    return fail(ErrorCode::kInvalidArgument, "give a recording, or sessions with --continue and --merge");
  if (options.simplemap)
    return fail(ErrorCode::kInvalidArgument,
                "--simplemap needs a recording: sessions do not keep whole scans");
  return {};
}

Result<void> read_params(const Arguments& arguments, mapping::MapperParams& params) {
  for (const auto& setting : arguments.all("--set")) {
    const auto equals = setting.find('=');
    if (equals == std::string::npos)
      return fail(ErrorCode::kInvalidArgument, "--set takes NAME=VALUE, not '" + setting + "'");
    if (auto set = mapping::set_param(params, setting.substr(0, equals), setting.substr(equals + 1)); !set)
      return set;
  }
  const std::vector<std::pair<const char*, const char*>> shortcuts = {
      {"--particles", "particles"}, {"--seed", "seed"}, {"--resolution", "delta"}};
  for (const auto& [option, name] : shortcuts) {
    const auto value = arguments.last(option);
    if (!value) continue;
    if (auto set = mapping::set_param(params, name, *value); !set)
      return fail(set.error().code, std::string(option) + ": " + set.error().message);
  }
  return mapping::validate(params);
}

Result<void> read_limits(const Arguments& arguments, MapOptions& options) {
  constexpr double kMaxScans = 1e9;
  const auto scans = arguments.number("--scans", 1, kMaxScans);
  if (!scans) return tl::unexpected(scans.error());
  if (*scans) options.max_scans = static_cast<std::size_t>(**scans);
  constexpr double kMaxRangeM = 1e4;
  const auto max_m = arguments.number("--sensor-max", 0.1, kMaxRangeM);
  if (!max_m) return tl::unexpected(max_m.error());
  options.reading.log.max_range_m = max_m->value_or(0);
  return {};
}

/// "intel" of "logs/intel.clf.bz2".
std::string name_of(const std::filesystem::path& recording) {
  std::filesystem::path name = recording.filename();
  while (name.has_extension() && name.has_stem()) name = name.stem();
  return name.string();
}

void read_names(const Arguments& arguments, MapOptions& options) {
  options.reading = recording_options(arguments);
  const std::string name = options.recording.empty() ? "merged" : name_of(options.recording);
  options.out = arguments.last("--out").value_or(name + "-map");
  options.relations = arguments.last("--relations");
  options.session = arguments.last("--continue");
  for (const auto& session : arguments.all("--merge")) options.merged.emplace_back(session);
  options.gridmap = arguments.last("--gridmap");
  options.simplemap = arguments.last("--simplemap");
  options.use_odometry = !arguments.has("--no-odometry");
  options.json = arguments.has("--json");
  options.quiet = arguments.has("--quiet");
}

}  // namespace

Result<MapOptions> read_map_options(const std::vector<std::string>& tokens) {
  const auto arguments = Arguments::read(
      tokens, {0,
               1,
               with_recording_options({"--out", "--particles", "--seed", "--resolution", "--set",
                                       "--relations", "--continue", "--start-pose", "--merge", "--gridmap",
                                       "--simplemap", "--scans", "--laser-pose", "--sensor-max"}),
               {"--no-odometry", "--json", "--quiet", "--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  MapOptions options;
  options.help = arguments->has("--help");
  if (options.help) return options;
  if (!arguments->operands().empty()) options.recording = arguments->operands()[0];
  read_names(*arguments, options);
  if (auto read = read_pose(*arguments, "--laser-pose", options.reading.log.base_T_sensor); !read)
    return tl::unexpected(read.error());
  if (auto read = read_pose(*arguments, "--start-pose", options.start_pose); !read)
    return tl::unexpected(read.error());
  if (auto checked = check(options); !checked) return tl::unexpected(checked.error());
  if (auto read = read_params(*arguments, options.params); !read) return tl::unexpected(read.error());
  if (auto read = read_limits(*arguments, options); !read) return tl::unexpected(read.error());
  return options;
}

std::string map_help() {
  std::ostringstream out;
  out << kHelp;
  const mapping::MapperParams defaults;
  constexpr std::size_t kNameWidth = 20;
  constexpr std::size_t kValueWidth = 16;
  for (const auto& name : mapping::param_names()) {
    std::string line = "  " + std::string(name.name);
    line.resize(kNameWidth, ' ');
    line += mapping::param_text(defaults, name) + " " + std::string(name.unit);
    line.resize(std::max(line.size() + 1, kNameWidth + kValueWidth), ' ');
    out << line << name.help << '\n';
  }
  out << kHelpEnd;
  return out.str();
}

}  // namespace extperfc::offline
