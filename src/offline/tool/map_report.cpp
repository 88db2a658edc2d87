#include "offline/tool/map_report.hpp"

#include <iomanip>
#include <sstream>

#include <nlohmann/json.hpp>

#include "extperfc/mapping/param_names.hpp"

#include "offline/tool/score_report.hpp"

namespace extperfc::offline {

namespace {

constexpr std::size_t kWorstShown = 5;

void print_scans(std::ostream& out, const MapReport& report) {
  const auto& result = report.result;
  const auto& statistics = report.statistics;
  if (report.options.session) out << "continued    " << report.options.session->string() << '\n';
  if (!report.options.recording.empty())
    out << "recording    " << report.options.recording.string() << '\n'
        << "scans        " << result.scans << " over " << std::setprecision(1) << result.recorded_s << " s";
  else
    out << "scans        " << result.trajectory.size();
  if (result.refused > 0) out << ", " << result.refused << " refused";
  if (result.damaged > 0) out << ", " << result.damaged << " damaged entries left out";
  if (result.without_odometry > 0) out << ", " << result.without_odometry << " without odometry";
  out << "\nkey frames   " << statistics.key_frames << ", " << statistics.unusable_scans
      << " scans unusable, odometry contradicted " << statistics.odometry_contradictions << " times\n"
      << "loops        " << statistics.loops << " closed, " << statistics.resamplings << " resamplings\n";
  for (const auto& session : report.options.merged) out << "merged       " << session.string() << '\n';
  if (statistics.carried > 0)
    out << "carried      the robot was found elsewhere " << statistics.carried << " times\n";
  if (statistics.parts > 1)
    out << "parts        " << statistics.parts
        << " whose poses to each other are unknown, side by side: no place of one was recognized in "
           "another\n";
  out << "path         " << std::setprecision(1) << statistics.path_m << " m (odometry " << result.odometry_m
      << " m)\n";
}

void print_cost(std::ostream& out, const MapReport& report) {
  const auto& result = report.result;
  const auto& cpu = result.cpu_ms;
  out << "map          " << report.map_width << " x " << report.map_height << " cells of "
      << std::setprecision(3) << report.options.params.resolution_m << " m\n"
      << "CPU          " << std::setprecision(2) << result.cpu_s << " s in all (" << result.wall_s
      << " s on the clock); each scan " << cpu.mean << " ms in the mean, " << cpu.p50 << " median, "
      << cpu.p99 << " for 99 %, " << cpu.max << " maximum\n"
      << "memory       " << std::setprecision(1) << report.peak_memory_mb << " MB peak\n";
}

}  // namespace

std::string report_text(const MapReport& report) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::fixed;
  print_scans(out, report);
  print_cost(out, report);
  if (report.result.interrupted) out << "interrupted: the rest of the recording is not in the map\n";
  if (!report.result.broken.empty()) out << "the recording ends early: " << report.result.broken << '\n';
  for (const auto& complaint : report.result.complaints) out << "left out: " << complaint << '\n';
  if (report.score) print_score(out, report.relations, *report.score, kWorstShown);
  return out.str();
}

std::string report_json(const MapReport& report) {
  const auto& result = report.result;
  const auto& statistics = report.statistics;
  nlohmann::json json{{"recording", report.options.recording.string()},
                      {"scans", result.scans},
                      {"scans_refused", result.refused},
                      {"entries_damaged", result.damaged},
                      {"scans_without_odometry", result.without_odometry},
                      {"recorded_s", result.recorded_s},
                      {"odometry_m", result.odometry_m},
                      {"interrupted", result.interrupted},
                      {"broken", result.broken},
                      {"cpu_s", result.cpu_s},
                      {"wall_s", result.wall_s},
                      {"cpu_ms_per_scan",
                       {{"mean", result.cpu_ms.mean},
                        {"p50", result.cpu_ms.p50},
                        {"p99", result.cpu_ms.p99},
                        {"max", result.cpu_ms.max}}},
                      {"complaints", result.complaints},
                      {"key_frames", statistics.key_frames},
                      {"scans_unusable", statistics.unusable_scans},
                      {"odometry_contradictions", statistics.odometry_contradictions},
                      {"loops_closed", statistics.loops},
                      {"carried", statistics.carried},
                      {"parts", statistics.parts},
                      {"resamplings", statistics.resamplings},
                      {"path_m", statistics.path_m},
                      {"map",
                       {{"width", report.map_width},
                        {"height", report.map_height},
                        {"resolution_m", report.options.params.resolution_m}}},
                      {"peak_memory_mb", report.peak_memory_mb}};
  for (const auto& name : mapping::param_names())
    std::visit([&](auto field) { json["parameters"][std::string(name.name)] = report.options.params.*field; },
               name.field);
  if (report.score) json["score"] = score_json(report.relations, *report.score, kWorstShown);
  return json.dump(2, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace extperfc::offline
