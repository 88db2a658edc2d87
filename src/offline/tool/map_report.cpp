#include "map_report.hpp"

#include <iomanip>
#include <sstream>

#include "extperfc/mapping/param_names.hpp"

#include "score_report.hpp"

namespace extperfc::offline::tool {

namespace {

constexpr std::size_t kWorstShown = 5;

void print_scans(std::ostream& out, const MapReport& report) {
  const auto& result = report.result;
  const auto& statistics = report.statistics;
  out << "recording    " << report.options.recording.string() << '\n'
      << "scans        " << result.scans << " over " << std::setprecision(1) << result.recorded_s << " s";
  if (result.refused > 0) out << ", " << result.refused << " refused";
  if (result.damaged > 0) out << ", " << result.damaged << " damaged entries left out";
  if (result.without_odometry > 0) out << ", " << result.without_odometry << " without odometry";
  out << "\nkey frames   " << statistics.key_frames << ", " << statistics.unusable_scans
      << " scans unusable, odometry contradicted " << statistics.odometry_contradictions << " times\n"
      << "loops        " << statistics.loops << " closed, " << statistics.resamplings << " resamplings\n"
      << "path         " << std::setprecision(1) << statistics.path_m << " m (odometry " << result.odometry_m
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

void write_result(JsonWriter& json, const MappingResult& result) {
  json.count("scans", result.scans);
  json.count("scans_refused", result.refused);
  json.count("entries_damaged", result.damaged);
  json.count("scans_without_odometry", result.without_odometry);
  json.number("recorded_s", result.recorded_s);
  json.number("odometry_m", result.odometry_m);
  json.boolean("interrupted", result.interrupted);
  json.text("broken", result.broken);
  json.number("cpu_s", result.cpu_s);
  json.number("wall_s", result.wall_s);
  json.begin_object("cpu_ms_per_scan");
  json.number("mean", result.cpu_ms.mean);
  json.number("p50", result.cpu_ms.p50);
  json.number("p99", result.cpu_ms.p99);
  json.number("max", result.cpu_ms.max);
  json.end_object();
  json.begin_array("complaints");
  for (const auto& complaint : result.complaints) json.text({}, complaint);
  json.end_array();
}

void write_statistics(JsonWriter& json, const mapping::MapperStatistics& statistics) {
  json.count("key_frames", statistics.key_frames);
  json.count("scans_unusable", statistics.unusable_scans);
  json.count("odometry_contradictions", statistics.odometry_contradictions);
  json.count("loops_closed", statistics.loops);
  json.count("resamplings", statistics.resamplings);
  json.number("path_m", statistics.path_m);
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
  JsonWriter json;
  json.begin_object();
  json.text("recording", report.options.recording.string());
  write_result(json, report.result);
  write_statistics(json, report.statistics);
  json.begin_object("map");
  json.count("width", report.map_width);
  json.count("height", report.map_height);
  json.number("resolution_m", report.options.params.resolution_m);
  json.end_object();
  json.number("peak_memory_mb", report.peak_memory_mb);
  json.begin_object("parameters");
  for (const auto& name : mapping::param_names())
    std::visit([&](auto field) { json.number(name.name, static_cast<double>(report.options.params.*field)); },
               name.field);
  json.end_object();
  if (report.score) write_score(json, "score", report.relations, *report.score, kWorstShown);
  json.end_object();
  return json.str();
}

}  // namespace extperfc::offline::tool
