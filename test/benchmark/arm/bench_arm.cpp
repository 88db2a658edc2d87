// What the arms' kinematics and planning cost and how often they succeed. Run with --help.
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/arguments.hpp"

#include "test/benchmark/arm/collision_part.hpp"
#include "test/benchmark/arm/constrained_part.hpp"
#include "test/benchmark/arm/depth_part.hpp"
#include "test/benchmark/arm/ik_part.hpp"
#include "test/benchmark/arm/planning_part.hpp"
#include "test/benchmark/arm/trajectory_part.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

struct Part {
  std::string name;
  std::function<Result<std::vector<Row>>(bool quick)> rows;
};

Result<std::vector<Row>> planning(const std::filesystem::path& problems, bool quick) {
  PlanningOptions options;
  options.problems = problems;
  if (!std::filesystem::is_directory(options.problems)) {
    std::cerr << "planning: left out, no such folder: " << options.problems.string() << "\n";
    return std::vector<Row>();
  }
  if (quick) {
    options.count = 10;
    options.seeds = 1;
    options.peer_count = 2;
    options.recheck_rad = 0.01;
  }
  return planning_rows(options);
}

Result<std::vector<Row>> trajectory(bool quick) {
  return trajectory_rows(quick);
}

Result<std::vector<Row>> constrained(bool quick) {
  ConstrainedOptions options;
  if (quick) {
    options.count = 20;
    options.peer_count = 2;
    options.recheck_rad = 0.01;
  }
  return constrained_rows(options);
}

std::vector<Part> parts(const std::filesystem::path& problems) {
  return {{"ik", ik_rows},
          {"collision", collision_rows},
          {"planning", [problems](bool quick) { return planning(problems, quick); }},
          {"constrained", constrained},
          {"trajectory", trajectory},
          {"depth", depth_rows}};
}

constexpr char kHelp[] =
    "usage: tools/bench arm [--quick] [--only PART] [--problems FOLDER] [--json FILE]\n\n"
    "Baxter's arms. CPU times, but wall times for planning.\n"
    "  ik          inverse kinematics of 100,000 random reachable poses with 1 ms each, against KDL's "
    "solvers with 5 ms\n"
    "  collision   states per second, motions proven free, spheres against Bullet\n"
    "  planning    every file of problems in a folder by three seeds, the left arm alone and both, "
    "against OMPL's RRTConnect on Bullet; paths and trajectories are looked through for hidden collisions\n"
    "  constrained a level tool over a table with boxes, against OMPL's constrained spaces\n"
    "  trajectory  time parameterizations of random paths\n"
    "  depth       a depth image as obstacles, and collision checks among its boxes\n\n"
    "  --quick   parts of everything, in less than a minute\n"
    "  --only    one part (default: all)\n"
    "  --problems  folder of planning problems (default: ../shared/data/arm; left out where it is absent)\n"
    "  --json    write the results too\n";

int complain(const std::string& message, int code) {
  std::cerr << "bench_arm: " << message << "\n";
  return code;
}

int run(const Arguments& arguments) {
  const std::string only = arguments.last("--only").value_or("");
  std::vector<Row> rows;
  bool any = false;
  const std::filesystem::path problems =
      arguments.last("--problems").value_or(EXTPERFC_SOURCE_DIR "/../shared/data/arm");
  for (const Part& part : parts(problems)) {
    if (!only.empty() && part.name != only) continue;
    any = true;
    auto found = part.rows(arguments.has("--quick"));
    if (!found) return complain(found.error().message, 1);
    rows.insert(rows.end(), found->begin(), found->end());
  }
  if (!any) return complain("there is no part '" + only + "'; see --help", 2);
  std::cout << machine_description() << "\n\n";
  print_table(std::cout, rows);
  const std::string json = arguments.last("--json").value_or("");
  if (json.empty() || write_json(json, "arm", rows)) return 0;
  return complain("cannot write " + json, 1);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc;
  const auto arguments = Arguments::read({argv + 1, argv + argc},
                                         {0, 0, {"--json", "--only", "--problems"}, {"--quick", "--help"}});
  if (!arguments) return benchmark::complain(arguments.error().message, 2);
  if (arguments->has("--help")) {
    std::cout << benchmark::kHelp;
    return 0;
  }
  return benchmark::run(*arguments);
}
