#include "test/benchmark/detect/report_rows.hpp"

#include <algorithm>
#include <cstdio>

namespace extperfc::benchmark {

namespace {

constexpr double kSpeedUpGoal = 2.2;  // OpenCV DNN / OpenVINO, CPU time of one thread

struct Part {
  const char* name;
  Cost cost;
};

std::vector<Part> parts_of(const DetectFigures& f) {
  return {{"wrap + preprocess", f.prepare},
          {"inference", f.inference},
          {"decode + NMS", f.decode},
          {"depth + messages", f.depth},
          {"transport + threads", f.transport()}};
}

void add_comparison(const std::string& name, const char* clock, double path_ms, double bare_ms,
                    std::vector<Row>& rows) {
  const std::string suffix = std::string(", ") + clock;
  rows.push_back({name, "path" + suffix, "ms", path_ms, bare_ms, "bare inference"});
  rows.push_back(at_most({name, "path adds" + suffix, "ms", path_ms - bare_ms}, overhead_goal_ms(bare_ms)));
}

void add_case(const DetectCase& what, const DetectFigures& f, std::vector<Row>& rows) {
  const std::string name = what.name();
  add_comparison(name, "wall", f.path.wall_ms, f.bare.wall_ms, rows);
  add_comparison(name, "wall 10 %", f.path_undisturbed_ms, f.bare_undisturbed_ms, rows);
  add_comparison(name, "CPU", f.path.cpu_ms, f.bare.cpu_ms, rows);
  rows.push_back({name, "path p95, wall", "ms", f.path_p95_ms});
  for (const auto& [part, cost] : parts_of(f)) {
    rows.push_back({name, std::string(part) + ", wall", "ms", cost.wall_ms});
    rows.push_back({name, std::string(part) + ", CPU", "ms", cost.cpu_ms});
  }
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
    const double ours = openvino->second.bare.cpu_ms;
    const double peer = opencv->second.bare.cpu_ms;
    const std::string name = measured.first.spec.name + " 1 thread";
    rows.push_back({name, "inference OpenVINO f32, CPU", "ms", ours, peer, "OpenCV DNN"});
    rows.push_back(at_least({name, "OpenCV DNN / OpenVINO, CPU", "x", peer / ours}, kSpeedUpGoal));
  }
}

}  // namespace

double overhead_goal_ms(double bare_ms) {
  constexpr double kFraction = 0.1;
  constexpr double kMinMs = 2.0;
  return std::max(kFraction * bare_ms, kMinMs);
}

std::vector<Row> rows_of(const std::vector<MeasuredCase>& cases) {
  std::vector<Row> rows;
  for (const auto& [what, figures] : cases) add_case(what, figures, rows);
  add_speed_ups(cases, rows);
  return rows;
}

void print_breakdown(const std::vector<MeasuredCase>& cases) {
  std::printf("%-36s %-4s %8s %8s %8s %10s %8s %8s %10s %6s %6s\n", "median ms per frame", "", "bare", "path",
              "prepare", "inference", "decode", "depth", "transport", "boxes", "in 3D");
  for (const auto& [what, f] : cases)
    for (const bool cpu : {false, true}) {
      const auto of = [cpu](const Cost& cost) { return cpu ? cost.cpu_ms : cost.wall_ms; };
      std::printf("%-36s %-4s %8.2f %8.2f %8.3f %10.2f %8.3f %8.3f %10.3f %6.1f %6.1f\n", what.name().c_str(),
                  cpu ? "CPU" : "wall", of(f.bare), of(f.path), of(f.prepare), of(f.inference), of(f.decode),
                  of(f.depth), of(f.transport()), f.mean_boxes, f.mean_objects);
    }
}

}  // namespace extperfc::benchmark
