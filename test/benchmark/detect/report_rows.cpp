#include "detect/report_rows.hpp"

#include <algorithm>
#include <cstdio>

namespace extperfc::benchmark {

namespace {

constexpr double kSpeedUpGoal = 2.2;  // OpenCV DNN / OpenVINO, CPU time of one thread

double transport_ms(const DetectFigures& figures) {
  return figures.path_wall_ms - figures.core_wall_ms;
}

void add_case(const DetectCase& what, const DetectFigures& f, std::vector<Row>& rows) {
  const std::string name = what.name();
  const char* const bare = "bare inference";
  rows.push_back({name, "path, wall", "ms", f.path_wall_ms, f.bare_wall_ms, bare});
  rows.push_back({name, "path, CPU", "ms", f.path_cpu_ms, f.bare_cpu_ms, bare});
  rows.push_back(at_most({name, "path adds, wall", "ms", f.path_wall_ms - f.bare_wall_ms},
                         overhead_goal_ms(f.bare_wall_ms)));
  rows.push_back(at_most({name, "path adds, CPU", "ms", f.path_cpu_ms - f.bare_cpu_ms},
                         overhead_goal_ms(f.bare_cpu_ms)));
  rows.push_back({name, "path p95, wall", "ms", f.path_p95_ms});
  rows.push_back({name, "wrap + preprocess", "ms", f.preprocess_ms});
  rows.push_back({name, "inference", "ms", f.inference_ms});
  rows.push_back({name, "decode + NMS", "ms", f.decode_ms});
  rows.push_back({name, "depth + messages", "ms", f.depth_ms});
  rows.push_back({name, "transport + threads", "ms", transport_ms(f)});
  rows.push_back({name, "boxes", "per frame", f.mean_boxes});
  rows.push_back({name, "boxes with depth", "per frame", f.mean_objects});
}

const MeasuredCase* find(const std::vector<MeasuredCase>& cases, const std::filesystem::path& folder,
                         const char* backend) {
  const auto found = std::find_if(cases.begin(), cases.end(), [&](const MeasuredCase& measured) {
    const auto& [what, figures] = measured;
    return what.spec.folder == folder && what.settings.inference.backend == backend &&
           what.settings.inference.threads == 1;
  });
  return found == cases.end() ? nullptr : &*found;
}

/// OpenVINO against OpenCV DNN, for every model that ran on both with one thread.
void add_speed_ups(const std::vector<MeasuredCase>& cases, std::vector<Row>& rows) {
  for (const auto& measured : cases) {
    const auto* const openvino = find(cases, measured.first.spec.folder, "openvino");
    const auto* const opencv = find(cases, measured.first.spec.folder, "opencv");
    if (!opencv || openvino != &measured) continue;
    const double ours = openvino->second.bare_cpu_ms;
    const double peer = opencv->second.bare_cpu_ms;
    const std::string name = measured.first.spec.name + " 1 thread";
    rows.push_back({name, "inference OpenVINO f32, CPU", "ms", ours, peer, "OpenCV DNN"});
    rows.push_back(at_least({name, "OpenCV DNN / OpenVINO, CPU", "x", peer / ours}, kSpeedUpGoal));
  }
}

}  // namespace

double overhead_goal_ms(double bare_ms) {
  constexpr double kFraction = 0.1;
  constexpr double kLeastMs = 2.0;
  return std::max(kFraction * bare_ms, kLeastMs);
}

std::vector<Row> rows_of(const std::vector<MeasuredCase>& cases) {
  std::vector<Row> rows;
  for (const auto& [what, figures] : cases) add_case(what, figures, rows);
  add_speed_ups(cases, rows);
  return rows;
}

void print_breakdown(const std::vector<MeasuredCase>& cases) {
  std::printf("%-34s %9s %9s %9s %9s %9s %9s %9s %9s %6s %6s\n", "ms per frame, median wall time", "bare",
              "path", "prepare", "inference", "decode", "depth", "transport", "path p95", "boxes", "in 3D");
  for (const auto& [what, f] : cases)
    std::printf("%-34s %9.2f %9.2f %9.3f %9.2f %9.3f %9.3f %9.3f %9.2f %6.1f %6.1f\n", what.name().c_str(),
                f.bare_wall_ms, f.path_wall_ms, f.preprocess_ms, f.inference_ms, f.decode_ms, f.depth_ms,
                transport_ms(f), f.path_p95_ms, f.mean_boxes, f.mean_objects);
}

}  // namespace extperfc::benchmark
