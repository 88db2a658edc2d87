// Navigation: global plans, and what runs while the robot drives. Run with --help.

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "test/benchmark/navigate/control_cases.hpp"
#include "test/benchmark/navigate/plan_cases.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

constexpr char kHelp[] =
    "bench_navigate [--only plan|control|drive] [--quick] [--map FILE.yaml] [--seed N] [--json FILE]\n"
    "  --only plan      global plans on generated offices, halls and mazes, against exact shortest paths, "
    "plain\n"
    "                   Dijkstra over eight neighbours, and OMPL's RRT* over x, y and yaw\n"
    "  --only control   control cycles of the local planner against the dynamic window approach, last-moment "
    "stop\n"
    "  --only drive     closed loops in generated buildings against the dynamic window approach\n"
    "  --seed N         of the first building that is driven in\n"
    "  --quick          fewer buildings and queries, no large maps\n"
    "  --floors NAME    of the global plans only those on office, hall, maze, map or growth (maps of 1000 to "
    "8000 cells)\n"
    "  --map FILE.yaml  a further map, as map_server has them\n"
    "Times are CPU times of one thread.\n";

struct Options {
  std::string only;
  PlanOptions plan;
  ControlOptions control;
  std::string json;
};

std::optional<Options> parse(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool value = i + 1 < arguments.size();
    if (arguments[i] == "--quick")
      options.plan.quick = options.control.quick = true;
    else if (arguments[i] == "--only" && value)
      options.only = arguments[++i];
    else if (arguments[i] == "--floors" && value)
      options.plan.floors = arguments[++i];
    else if (arguments[i] == "--map" && value)
      options.plan.real_map = arguments[++i];
    else if (arguments[i] == "--seed" && value)
      options.control.first_seed = std::strtoull(arguments[++i].c_str(), nullptr, 10);
    else if (arguments[i] == "--json" && value)
      options.json = arguments[++i];
    else
      return std::nullopt;
  }
  const bool known =
      options.only.empty() || options.only == "plan" || options.only == "control" || options.only == "drive";
  return known ? std::optional<Options>(options) : std::nullopt;
}

int run(const Options& options) {
  std::cout << machine_description() << "\n\n";
  std::vector<Row> rows;
  if (options.only.empty() || options.only == "plan") measure_plans(options.plan, rows);
  if (options.only.empty() || options.only == "control") measure_control(options.control, rows);
  if (options.only.empty() || options.only == "drive") measure_drives(options.control, rows);
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
