#include <algorithm>
#include <iostream>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "extperfc/base/arguments.hpp"
#include "extperfc/offline/image.hpp"
#include "extperfc/offline/recording.hpp"
#include "extperfc/offline/relations.hpp"
#include "extperfc/world/map_file.hpp"

#include "offline/tool/program.hpp"
#include "offline/tool/recording_options.hpp"
#include "offline/tool/score_report.hpp"

namespace extperfc::offline {
namespace {

constexpr const char* kProgram = "extperfc-relations";

constexpr const char* kHelp = R"(Scores a trajectory against known relations between poses.

  extperfc-relations TRAJECTORY RELATIONS [OPTION ...]

TRAJECTORY: TUM format, a line `stamp x y z qx qy qz qw` a pose.
RELATIONS:  a line `i j x y z roll pitch yaw` a relation: pose of the scanner at scan j in its frame at scan i [m, rad].
            Scans are numbered from 0 in the order of their recording.

Prints the metric of Kuemmerle et al. 2009: mean and standard deviation of the translational and the rotational error,
absolute and squared, for all relations, for neighbours, and for loops (scans that are more than 100 apart).

A trajectory that holds every scan needs no more. One that holds only some of them (as most mappers write) needs the
recording: poses and scans are then matched by their stamps, and odometry fills the gaps between two poses. Poses are
those of the robot; where the scanner sits on it says the recording, or --laser-pose.

Options:
  --odometry RECORDING   the recording: CARMEN log, ROS bag or MRPT rawlog, as extperfc-map reads them
  --laser-pose X,Y,YAW   pose of the scanner on the robot [m, m, rad]; overrides the recording, 0,0,0 without one
  --loop-span N          minimum number of scans that a loop spans, 101 by default
  --worst N              relations to list, 10 by default
  --image FILE.png       draws the trajectory, and each relation from green over yellow to red (0.15 m off or more)
  --map MAP.yaml         background of that image
  --json                 for programs
  --scan-topic TOPIC, --odom-topic TOPIC, --base-frame FRAME, --odom-frame FRAME, --sensor LABEL
                         how to read the recording, see extperfc-map --help

Example:
  extperfc-relations intel/trajectory.tum intel.relations --map intel/map.yaml --image relations.png

Exit status: 0 done, 1 failed (reason on standard error), 2 wrong usage.
)";

constexpr double kMaxCount = 1e8;

/// A trajectory's poses by the scans' numbers.
struct ScanPoses {
  std::vector<std::optional<Pose2>> poses;
  Pose2 base_T_scanner;
};

Result<ScanPoses> poses_by_recording(const std::string& file, const RecordingOptions& reading,
                                     const Trajectory& trajectory) {
  auto log = open_recording(file, reading);
  if (!log) return tl::unexpected(log.error());
  std::vector<ScanMoment> moments;
  ScanPoses found;
  while (true) {
    const auto record = (*log)->next();
    if (!record) return tl::unexpected(record.error());
    if (!*record) break;
    if (moments.empty()) found.base_T_scanner = (*record)->scan.base_T_sensor;
    moments.push_back({(*record)->index, (*record)->scan.stamp_s, (*record)->odom_T_base});
  }
  auto poses = poses_of_scans(trajectory, moments);
  if (!poses) return tl::unexpected(poses.error());
  found.poses = *std::move(poses);
  return found;
}

/// Without a recording the trajectory must hold every scan.
Result<std::vector<std::optional<Pose2>>> poses_one_by_one(const Trajectory& trajectory,
                                                           const std::vector<Relation>& relations) {
  std::size_t max_index = 0;
  for (const auto& relation : relations) max_index = std::max({max_index, relation.from, relation.to});
  if (max_index >= trajectory.size())
    return fail(ErrorCode::kInvalidArgument,
                "the trajectory holds " + std::to_string(trajectory.size()) +
                    " poses and a relation names scan " + std::to_string(max_index) +
                    ": give the recording (--odometry RECORDING), so that poses can be "
                    "matched by their stamps");
  std::vector<std::optional<Pose2>> poses;
  poses.reserve(trajectory.size());
  for (const auto& stamped : trajectory) poses.emplace_back(stamped.pose);
  return poses;
}

Result<ScanPoses> find_poses(const Arguments& arguments, const Trajectory& trajectory,
                             const std::vector<Relation>& relations) {
  auto reading = recording_options(arguments);
  auto& base_T_scanner = reading.log.base_T_sensor;
  if (auto read = read_pose(arguments, "--laser-pose", base_T_scanner); !read)
    return tl::unexpected(read.error());
  if (const auto recording = arguments.last("--odometry"))
    return poses_by_recording(*recording, reading, trajectory);
  auto poses = poses_one_by_one(trajectory, relations);
  if (!poses) return tl::unexpected(poses.error());
  return ScanPoses{*std::move(poses), base_T_scanner.value_or(Pose2{})};
}

Result<void> draw(const Arguments& arguments, const std::vector<std::optional<Pose2>>& poses,
                  const std::vector<Relation>& relations, const RelationsScore& score) {
  const auto image = arguments.last("--image");
  if (!image) return {};
  OccupancyGrid map;
  if (const auto file = arguments.last("--map")) {
    auto loaded = load_map(*file);
    if (!loaded) return tl::unexpected(loaded.error());
    map = *std::move(loaded);
  }
  return write_png(draw_relations(map, poses, relations, score), *image);
}

struct Limits {
  std::size_t loop_span{kLoopSpan};
  std::size_t worst{10};
};

Result<Limits> read_limits(const Arguments& arguments) {
  Limits limits;
  const auto span = arguments.number("--loop-span", 1, kMaxCount);
  if (!span) return tl::unexpected(span.error());
  const auto worst = arguments.number("--worst", 0, kMaxCount);
  if (!worst) return tl::unexpected(worst.error());
  if (*span) limits.loop_span = static_cast<std::size_t>(**span) - 1;
  if (*worst) limits.worst = static_cast<std::size_t>(**worst);
  return limits;
}

Result<void> score(const Arguments& arguments, const Limits& limits) {
  const auto trajectory = read_tum(arguments.operands()[0]);
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto relations = read_relations(arguments.operands()[1]);
  if (!relations) return tl::unexpected(relations.error());
  const auto found = find_poses(arguments, *trajectory, *relations);
  if (!found) return tl::unexpected(found.error());
  const auto score = score_relations(*relations, found->poses, {found->base_T_scanner, limits.loop_span});
  if (score.errors.empty())
    return fail(ErrorCode::kInvalidArgument, "the trajectory has no pose for any of the " +
                                                 std::to_string(relations->size()) + " relations");
  if (auto drawn = draw(arguments, found->poses, *relations, score); !drawn) return drawn;
  if (!arguments.has("--json")) {
    print_score(std::cout, *relations, score, limits.worst);
    return {};
  }
  const nlohmann::json json{{"poses", trajectory->size()},
                            {"score", score_json(*relations, score, limits.worst)}};
  std::cout << json.dump(2) << '\n';
  return {};
}

int run_tool(const std::vector<std::string>& tokens) {
  const auto arguments = Arguments::read(
      tokens,
      {2,
       2,
       with_recording_options({"--odometry", "--laser-pose", "--loop-span", "--worst", "--image", "--map"}),
       {"--json", "--help"}});
  const auto limits = arguments ? read_limits(*arguments) : Result<Limits>(tl::unexpected(arguments.error()));
  if (!limits) return complain(kProgram, limits.error().message, kUsage);
  if (arguments->has("--help")) {
    std::cout << kHelp;
    return kDone;
  }
  const auto done = score(*arguments, *limits);
  return done ? kDone : complain(kProgram, done.error().message);
}

}  // namespace
}  // namespace extperfc::offline

int main(int argc, char** argv) {
  using namespace extperfc::offline;  // NOLINT: a program, not a header
  return run_program(kProgram, argc, argv, run_tool);
}
