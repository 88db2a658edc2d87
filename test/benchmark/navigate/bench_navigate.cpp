// Navigation: global plans, and what runs while the robot drives. Run with --help.

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "test/benchmark/navigate/plan_cases.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kHelp[] =
    "bench_navigate [--only plan] [--quick] [--map FILE.yaml] [--json FILE]\n"
    "  --only plan      global plans on generated offices, halls and mazes, against exact shortest paths, "
    "plain\n"
    "                   Dijkstra over eight neighbours, and OMPL's RRT* over x, y and yaw\n"
    "  --quick          fewer buildings and queries, no large maps\n"
    "  --map FILE.yaml  a further map, as map_server has them\n"
    "Times are CPU times of one thread.\n";

struct Options {
  std::string only;
  PlanOptions plan;
  std::string json;
};

std::optional<Options> parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool value = i + 1 < arguments.size();
    if (arguments[i] == "--quick")
      options.plan.quick = true;
    else if (arguments[i] == "--only" && value)
      options.only = arguments[++i];
    else if (arguments[i] == "--map" && value)
      options.plan.real_map = arguments[++i];
    else if (arguments[i] == "--json" && value)
      options.json = arguments[++i];
    else
      return std::nullopt;
  }
  const bool known = options.only.empty() || options.only == "plan";
  return known ? std::optional<Options>(options) : std::nullopt;
}

int run(const Options& options) {
  std::cout << machine_description() << "\n\n";
  std::vector<Row> rows;
  if (options.only.empty() || options.only == "plan") measure_plans(options.plan, rows);
  print_table(std::cout, rows);
  if (options.json.empty() || write_json(options.json, "navigate", rows)) return EXIT_SUCCESS;
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
