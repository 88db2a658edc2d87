// What it costs to translate between two masters. Run with --help.

#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include <ros/init.h>
#include <ros/node_handle.h>

#include "extperfc/base/stopwatch.hpp"

#include "test/benchmark/report.hpp"
#include "test/benchmark/translate/conversion.hpp"
#include "test/benchmark/translate/latency.hpp"
#include "test/benchmark/translate/load.hpp"
#include "test/benchmark/translate/options.hpp"
#include "test/benchmark/translate/parts.hpp"
#include "test/benchmark/translate/stage.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kExplanation[] =
    "latency: from the monotonic clock's time in the message, read just before publishing, to the "
    "subscriber's\n"
    "callback; one message at a time, over loopback with tcp_nodelay. direct: publisher -> subscriber. "
    "relay: through\n"
    "a roscpp node that takes and publishes raw bytes. pass, convert: through the translator, with "
    "definitions that\n"
    "are the same and that differ. The four routes alternate, in ten blocks each. CPU: of the process in the "
    "middle.\n";

int complain(const std::string& message, int code) {
  std::cerr << "bench_translate: " << message << "\n";
  return code;
}

void append(std::vector<Row>& rows, std::vector<Row> more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

Result<std::vector<Row>> measure_ros(const TranslateOptions& options) {
  const auto stage = Stage::make();
  if (!stage) return tl::unexpected(stage.error());
  start_ros(stage->robot_uri(), "bench_translate");
  ros::NodeHandle handle;
  std::vector<Row> rows;
  if (options.only != "load") {
    auto latency = latency_rows(*stage, options);
    if (!latency) return latency;
    append(rows, std::move(*latency));
  }
  if (options.only != "latency") {
    auto load = load_rows(*stage, options);
    if (!load) return load;
    append(rows, std::move(*load));
  }
  ros::shutdown();
  return rows;
}

Result<std::vector<Row>> measure(const TranslateOptions& options) {
  std::vector<Row> rows;
  if (options.only.empty() || options.only == "conversion") {
    auto conversion = conversion_rows();
    if (!conversion) return conversion;
    append(rows, std::move(*conversion));
  }
  if (options.only != "conversion") {
    auto ros = measure_ros(options);
    if (!ros) return ros;
    append(rows, std::move(*ros));
  }
  return rows;
}

int run(const TranslateOptions& options) {
  const Stopwatch watch;
  const auto rows = measure(options);
  if (!rows) return complain(rows.error().message, 1);
  std::printf("%s\n%s\n", machine_description().c_str(), kExplanation);
  std::fflush(stdout);
  print_table(std::cout, *rows);
  std::cout << "\n" << watch.seconds() << " s\n";
  if (options.json.empty() || write_json(options.json, "translate", *rows)) return 0;
  return complain("cannot write " + options.json, 1);
}

int run_part(const std::vector<std::string>& tokens) {
  const std::vector<std::string> arguments(tokens.begin() + 1, tokens.end());
  if (tokens.front() == "receiver") return run_receiver(arguments);
  if (tokens.front() == "relay") return run_relay(arguments);
  return run_bridge(arguments);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;
  if (argc > 3 && std::string(argv[1]) == "--part") return run_part({argv + 2, argv + argc});
  const auto options = parse_translate_options(argc, argv);
  if (!options) return complain(options.error().message, 2);
  if (options->help) {
    print_translate_help(std::cout);
    return 0;
  }
  return run(*options);
}
