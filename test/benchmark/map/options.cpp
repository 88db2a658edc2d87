#include "test/benchmark/map/options.hpp"

#include <set>

#include "extperfc/base/arguments.hpp"

namespace extperfc::benchmark {
namespace {

const std::set<std::string> kParts{"log", "peer", "rates", "hall", kWorldsPart};
constexpr int kMaxSeeds = 100;
constexpr int kMaxWorlds = 1000;

MapOptions quick_options() {
  MapOptions options;
  options.quick = true;
  options.seeds = 1;
  options.scans = 2'500;
  options.peer_scans = 1'000;
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

}  // namespace

Result<MapOptions> parse_map_options(const std::vector<std::string>& tokens) {
  const auto arguments = Arguments::read(
      tokens, {0, 0, {"--json", "--seeds", "--peer-scans", "--only", "--worlds"}, {"--quick", "--help"}});
  if (!arguments) return tl::unexpected(arguments.error());
  MapOptions options = arguments->has("--quick") ? quick_options() : MapOptions{};
  options.help = arguments->has("--help");
  options.json = arguments->last("--json").value_or("");
  options.only = arguments->last("--only").value_or("");
  if (!options.only.empty() && kParts.count(options.only) == 0)
    return fail(ErrorCode::kInvalidArgument,
                "--only needs log, peer, rates, hall or worlds, not '" + options.only + "'");
  if (auto read = read_count(*arguments, "--seeds", kMaxSeeds, options.seeds); !read)
    return tl::unexpected(read.error());
  const auto peer_scans = arguments->number("--peer-scans", 0, static_cast<double>(kWholeLog));
  if (!peer_scans) return tl::unexpected(peer_scans.error());
  if (*peer_scans)
    options.peer_scans = **peer_scans == 0 ? kWholeLog : static_cast<std::size_t>(**peer_scans);
  if (arguments->has("--worlds") && options.only != kWorldsPart)
    return fail(ErrorCode::kInvalidArgument, "--worlds goes with --only worlds");
  if (auto read = read_count(*arguments, "--worlds", kMaxWorlds, options.worlds); !read)
    return tl::unexpected(read.error());
  return options;
}

void print_map_help(std::ostream& out) {
  out << "usage: tools/bench map [--quick] [--seeds N] [--peer-scans N] [--only PART] [--json FILE]\n"
         "       tools/bench map --only worlds [--worlds N] [--json FILE]\n\n"
         "Accuracy, CPU time and memory of the mapper on the Intel Research Lab's log (../shared/data/slam; "
         "where it is\n"
         "absent, on a generated building), against MRPT's rbpf-slam in the same run; what particles, the "
         "map's size and\n"
         "the scans' rate cost; the time of map().\n\n"
         "  --quick       parts of everything, in less than a minute\n"
         "  --seeds       with 30 particles (default 3); at most 3 with other numbers\n"
         "  --peer-scans  of the log, for rbpf-slam (default 4000; 0: all, which takes minutes)\n"
         "  --only        log, peer, rates or hall (default: all four), or worlds: accuracy and CPU time in\n"
         "                generated buildings of ten kinds; takes minutes, and runs only when asked for\n"
         "  --worlds      of every kind (default 2)\n"
         "  --json        write the results too\n";
}

}  // namespace extperfc::benchmark
