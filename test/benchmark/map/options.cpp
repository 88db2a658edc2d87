#include "test/benchmark/map/options.hpp"

#include <algorithm>
#include <set>

#include "extperfc/base/arguments.hpp"

#include "test/benchmark/map/subjects.hpp"

namespace extperfc::benchmark {
namespace {

const std::set<std::string> kParts{"log", "peer", "rates", "hall", kVariedPart, kWorldsPart, kLongPart};
constexpr int kMaxSeeds = 100;
constexpr int kMaxWorlds = 1000;

MapOptions quick_options() {
  MapOptions options;
  options.quick = true;
  options.seeds = 1;
  options.scans = 1'000;
  options.peer_scans = 300;
  options.drive_s = 60;
  options.worlds = 1;
  return options;
}

/// From 1 on; an option that is not given leaves `count` as it is.
Result<void> read_count(const Arguments& arguments, const std::string& option, int max_count, int& count) {
  const auto given = arguments.number(option, 1, max_count);
  if (!given) return tl::unexpected(given.error());
  if (*given) count = static_cast<int>(**given);
  return {};
}

/// What is measured and on which log.
Result<void> read_choice(const Arguments& arguments, MapOptions& options) {
  options.only = arguments.last("--only").value_or("");
  if (!options.only.empty() && kParts.count(options.only) == 0)
    return fail(ErrorCode::kInvalidArgument,
                "--only needs log, peer, rates, hall, varied, worlds or long, not '" + options.only + "'");
  options.log = arguments.last("--log").value_or("");
  const auto& logs = log_names();
  if (arguments.has("--log") && std::find(logs.begin(), logs.end(), options.log) == logs.end())
    return fail(ErrorCode::kInvalidArgument,
                "--log needs intel, fr079 or mit-csail, not '" + options.log + "'");
  return {};
}

}  // namespace

Result<MapOptions> parse_map_options(const std::vector<std::string>& tokens) {
  const auto arguments = Arguments::read(
      tokens,
      {0, 0, {"--json", "--seeds", "--peer-scans", "--only", "--log", "--worlds"}, {"--quick", "--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  MapOptions options = arguments->has("--quick") ? quick_options() : MapOptions{};
  options.help = arguments->has("--help");
  options.json = arguments->last("--json").value_or("");
  if (auto read = read_choice(*arguments, options); !read) return tl::unexpected(read.error());
  if (auto read = read_count(*arguments, "--seeds", kMaxSeeds, options.seeds); !read)
    return tl::unexpected(read.error());
  const auto peer_scans = arguments->number("--peer-scans", 0, static_cast<double>(kWholeLog));
  if (!peer_scans) return tl::unexpected(peer_scans.error());
  if (*peer_scans)
    options.peer_scans = **peer_scans == 0 ? kWholeLog : static_cast<std::size_t>(**peer_scans);
  if (arguments->has("--worlds") && options.only != kWorldsPart && options.only != kLongPart)
    return fail(ErrorCode::kInvalidArgument, "--worlds goes with --only worlds or --only long");
  if (auto read = read_count(*arguments, "--worlds", kMaxWorlds, options.worlds); !read)
    return tl::unexpected(read.error());
  return options;
}

void print_map_help(std::ostream& out) {
  out << "usage: tools/bench map [--quick] [--seeds N] [--log NAME] [--peer-scans N] [--only PART]\n"
         "                       [--json FILE]\n"
         "       tools/bench map --only worlds|long [--worlds N] [--json FILE]\n"
         "\n"
         "Accuracy, CPU time and memory of the mapper on the logs of three buildings (../shared/data/slam;\n"
         "where none is there, on a generated building), against MRPT's rbpf-slam and icp-slam and odometry\n"
         "alone in the same run; what particles, the map's size and the scans' rate cost; the time of "
         "map().\n"
         "\n"
         "  --quick       parts of everything, in about a minute\n"
         "  --seeds       of every log with 30 particles (default 3); with 1, 10 and 100 particles at most "
         "3,\n"
         "                on the first log alone\n"
         "  --log         intel, fr079 or mit-csail (default: all that are there)\n"
         "  --peer-scans  of every log, for the peers (default 0: all of them, or the longest first part "
         "that\n"
         "                a peer does in ten minutes of CPU; takes most of an hour)\n"
         "  --only        log, peer, rates or hall (default: all four). Only when asked for, since they "
         "take\n"
         "                minutes: varied, the logs with a poorer scanner, worse wheels, missing scans, and\n"
         "                backwards; worlds, generated buildings of ten kinds; long, drives of 1.9 km\n"
         "  --worlds      of every kind (default 2)\n"
         "  --json        write the results too\n";
}

}  // namespace extperfc::benchmark
