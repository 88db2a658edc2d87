// What the simulator costs, in parts and as a whole. Run with --help.

#include <cstdio>
#include <iostream>

#include <ros/init.h>
#include <ros/master.h>
#include <ros/package.h>

#include "test/benchmark/ros_log.hpp"
#include "test/benchmark/sim/core_cost.hpp"
#include "test/benchmark/sim/options.hpp"
#include "test/benchmark/sim/whole_robot.hpp"

namespace extperfc::benchmark {
namespace {

int complain(const std::string& message, int code) {
  std::cerr << "bench_sim: " << message << "\n";
  return code;
}

int run(const SimOptions& options) {
  const auto stage = load_stage(ros::package::getPath("extperfc"), options.world);
  if (!stage) return complain(stage.error().message, 1);
  std::printf("%s\n", machine_description().c_str());
  auto rows = core_rows(*stage, options.frames);
  if (!rows) return complain(rows.error().message, 1);
  const auto whole = whole_robot_rows(options.world, options.seconds);
  if (!whole) return complain(whole.error().message, 1);
  rows->insert(rows->end(), whole->begin(), whole->end());
  std::printf("%.0f s per measurement of the whole robot, %d frames per sensor, medians\n\n", options.seconds,
              options.frames);
  print_table(std::cout, *rows);
  if (options.json.empty() || write_json(options.json, "sim", *rows)) return 0;
  return complain("cannot write " + options.json, 1);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;
  ros::init(argc, argv, "bench_sim", ros::init_options::AnonymousName);
  const auto options = parse_sim_options(argc, argv);
  if (!options) return complain(options.error().message, 2);
  if (options->help) {
    print_sim_help(std::cout);
    return 0;
  }
  log_warnings_only();
  if (!ros::master::check()) return complain("no ROS master: start this with tools/bench sim", 1);
  use_simulated_time();
  return run(*options);
}
