// The cost of an image through the nodelets, against inference alone. Run with --help.

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <thread>

#include <ros/init.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <ros/package.h>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/detect/inference.hpp"

#include "test/benchmark/detect/footage.hpp"
#include "test/benchmark/detect/measure.hpp"
#include "test/benchmark/detect/options.hpp"
#include "test/benchmark/detect/report_rows.hpp"
#include "test/benchmark/report.hpp"
#include "test/benchmark/ros_log.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr char kExplanation[] =
    "bare: the network alone. path: from the camera's publish to the callback with 3D detections, through "
    "the\n"
    "nodelets detector and box_depth in one manager. prepare to depth: the same work called straight.\n"
    "transport: path minus that work, i.e. topics, queues and threads. Medians; wall 10 %: the 10 % "
    "quantile.\n"
    "Beside another load on the machine trust CPU time, then the 10 % quantile.\n";

/// Described folders in models/ of the package, and those of the command line.
std::vector<fs::path> model_folders(const DetectOptions& options) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(ros::package::getPath("extperfc") + "/models", ignored))
    if (fs::exists(entry.path() / "model.yaml", ignored)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const auto& folder : options.models) folders.push_back(fs::absolute(folder));
  return folders;
}

std::vector<int> thread_counts(const DetectOptions& options) {
  const int all = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (!options.threads.empty()) return options.threads;
  return all == 1 ? std::vector<int>{1} : std::vector<int>{1, all};
}

std::vector<std::string> backends(const DetectOptions& options) {
  const auto available = detect::available_backends();
  std::vector<std::string> chosen;
  for (const auto& name : options.backends)
    if (std::find(available.begin(), available.end(), name) != available.end()) chosen.push_back(name);
  return chosen;
}

/// One library after the other, because OpenCV's number of threads holds for the whole process.
Result<std::vector<DetectCase>> all_cases(const DetectOptions& options) {
  std::vector<DetectCase> cases;
  const auto folders = model_folders(options);
  if (folders.empty()) return fail(ErrorCode::kNotFound, "there is no model: give a folder with --model");
  for (const auto& folder : folders) {
    auto spec = detect::load_model_spec(folder, ros::package::getPath("extperfc") + "/config/models");
    if (!spec) return tl::unexpected(spec.error());
    for (const auto& backend : backends(options))
      for (const int threads : thread_counts(options)) {
        DetectCase one{*spec, {folder, {}, options.score}};
        one.settings.inference.backend = backend;
        one.settings.inference.threads = threads;
        cases.push_back(one);
      }
  }
  if (cases.empty()) return fail(ErrorCode::kUnsupported, "this build has none of the back ends asked for");
  return cases;
}

Result<std::vector<MeasuredCase>> measure_all(const DetectOptions& options) {
  const auto cases = all_cases(options);
  if (!cases) return tl::unexpected(cases.error());
  const auto footage =
      options.images.empty() ? Result<Footage>(draw_footage()) : load_footage(options.images);
  if (!footage) return tl::unexpected(footage.error());
  std::vector<MeasuredCase> measured;
  for (const auto& one : *cases) {
    auto figures = measure(one, *footage, options.frames, static_cast<int>(measured.size()));
    if (!figures) return fail(figures.error().code, one.name() + ": " + figures.error().message);
    std::fprintf(stderr, "%s: %s\n", one.name().c_str(), figures->execution.c_str());
    measured.emplace_back(one, std::move(*figures));
  }
  return measured;
}

/// The breakdown above has the rest.
std::vector<Row> compared(const std::vector<Row>& rows) {
  std::vector<Row> chosen;
  for (const auto& row : rows)
    if (row.goal || row.peer) chosen.push_back(row);
  return chosen;
}

int complain(const std::string& message, int code) {
  std::cerr << "bench_detect: " << message << "\n";
  return code;
}

int run(const DetectOptions& options) {
  const Stopwatch watch;
  const auto measured = measure_all(options);
  if (!measured) return complain(measured.error().message, 1);
  std::printf("%s\n%d frames of each kind per case, %s\n%s\n", machine_description().c_str(), options.frames,
              options.images.empty() ? "one drawn image" : options.images.c_str(), kExplanation);
  print_breakdown(*measured);
  std::printf("\n");
  std::fflush(stdout);
  const auto rows = rows_of(*measured);
  print_table(std::cout, compared(rows));
  std::cout << "\n" << watch.seconds() << " s\n";
  if (options.json.empty() || write_json(options.json, "detect", rows)) return 0;
  return complain("cannot write " + options.json, 1);
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  using namespace extperfc::benchmark;
  ros::init(argc, argv, "bench_detect", ros::init_options::AnonymousName);
  const auto options = parse_detect_options(argc, argv);
  if (!options) return complain(options.error().message, 2);
  if (options->help) {
    print_help(std::cout);
    return 0;
  }
  log_warnings_only();
  if (!ros::master::check()) return complain("no ROS master: start this with tools/bench detect", 1);
  const ros::NodeHandle keep_running;
  return run(*options);
}
