// What mapping costs, and how good the map is. Run with --help.

#include <cstdio>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/map/log_part.hpp"
#include "test/benchmark/map/options.hpp"
#include "test/benchmark/map/rows.hpp"
#include "test/benchmark/map/subjects.hpp"
#include "test/benchmark/map/varied_part.hpp"
#include "test/benchmark/map/worlds_part.hpp"
#include "test/benchmark/report.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kExplanation[] =
    "errors: mean over the relations of the metric of Kuemmerle et al. 2009, absolute values. CPU: of all "
    "threads; of the log:\n"
    "reading and mapping; per scan: Mapper::add alone. Peak memory: of a process that does only this, the "
    "map "
    "drawn. Each run is\n"
    "a separate process.\n";

constexpr char kWorldsExplanation[] =
    "errors: mean over pairs of poses that truly stand within 1 m of each other, 15 m of path or more apart, "
    "when the\n"
    "drive is over. CPU per scan: Mapper::add alone. Each drive is a separate process.\n";

int complain(const std::string& message, int code) {
  std::cerr << "bench_map: " << message << "\n";
  return code;
}

Result<std::vector<Row>> measure(const MapOptions& options) {
  if (options.only == kWorldsPart) return world_rows(options);
  if (options.only == kLongPart) return long_rows(options);
  const TemporaryFolder folder;
  const auto subjects = find_subjects(options.log, folder.path());
  if (!subjects) return tl::unexpected(subjects.error());
  if (options.only == kVariedPart) return varied_rows(*subjects);
  struct Part {
    const char* name;
    std::function<Result<std::vector<Row>>()> rows;
  };
  const std::vector<Part> parts{{"log", [&] { return log_rows(*subjects, options); }},
                                {"peer", [&] { return peer_rows(*subjects, options); }},
                                {"rates", [&] { return rate_rows(options); }},
                                {"hall", [&] { return map_call_rows(subjects->front(), options); }}};
  std::vector<Row> rows;
  for (const auto& part : parts) {
    if (!options.only.empty() && options.only != part.name) continue;
    auto more = part.rows();
    if (!more) return more;
    rows.insert(rows.end(), more->begin(), more->end());
  }
  return rows;
}

int run(const MapOptions& options) {
  const Stopwatch watch;
  const auto rows = measure(options);
  if (!rows) return complain(rows.error().message, 1);
  const bool is_generated = options.only == kWorldsPart || options.only == kLongPart;
  std::cout << machine_description() << "\n" << (is_generated ? kWorldsExplanation : kExplanation) << "\n";
  print_table(std::cout, *rows);
  std::cout << "\n" << watch.seconds() << " s\n";
  if (options.json.empty() || write_json(options.json, "map", *rows)) return 0;
  return complain("cannot write " + options.json, 1);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;  // NOLINT
  const std::vector<std::string> tokens(argv + 1, argv + argc);
  try {
    if (tokens.size() > 2 && tokens[0] == "--part" && tokens[1] == "log")
      return run_log_part({tokens.begin() + 2, tokens.end()});
    if (tokens.size() > 2 && tokens[0] == "--part" && tokens[1] == "world")
      return run_world_part({tokens.begin() + 2, tokens.end()});
    const auto options = parse_map_options(tokens);
    if (!options) return complain(options.error().message, 2);
    if (options->help) {
      print_map_help(std::cout);
      return 0;
    }
    return run(*options);
  } catch (const std::exception& error) {
    return complain(error.what(), 1);
  }
}
