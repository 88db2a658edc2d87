#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace extperfc::benchmark {

/// One comparison of a benchmark. Values that do not exist stay empty and become `null` in JSON.
struct Row {
  std::string case_name;
  std::string metric;
  std::string unit;
  double ours{0};
  std::optional<double> peer{};
  std::string peer_name{};
  std::optional<double> goal{};
  std::optional<bool> met{};

  /// ours / peer, when both mean something.
  [[nodiscard]] std::optional<double> ratio() const {
    if (!peer || !std::isfinite(*peer) || !std::isfinite(ours) || *peer == 0.0) return std::nullopt;
    return ours / *peer;
  }
};

/// The row with a goal of "not more than `limit`".
[[nodiscard]] inline Row at_most(Row row, double limit) {
  row.goal = limit;
  row.met = row.ours <= limit;
  return row;
}

/// The row with a goal of "not less than `limit`".
[[nodiscard]] inline Row at_least(Row row, double limit) {
  row.goal = limit;
  row.met = row.ours >= limit;
  return row;
}

/// Processor and number of hardware threads, e.g. "Some CPU @ 2.40GHz, 4 threads".
[[nodiscard]] inline std::string machine_description() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(cpuinfo, line);) {
    const auto colon = line.find(": ");
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    model = line.substr(colon + 2);
    break;
  }
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads";
}

namespace detail {

[[nodiscard]] inline std::string number(std::optional<double> value, const char* absent) {
  if (!value || !std::isfinite(*value)) return absent;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", *value);
  return text.data();
}

[[nodiscard]] inline std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + '"';
}

[[nodiscard]] inline const char* truth(std::optional<bool> value, const char* yes, const char* no,
                                       const char* absent) {
  return value ? (*value ? yes : no) : absent;
}

constexpr std::size_t kColumns = 9;
using Line = std::array<std::string, kColumns>;

[[nodiscard]] inline Line table_line(const Row& row) {
  return {row.case_name,
          row.metric,
          row.unit,
          number(row.ours, "-"),
          number(row.peer, "-"),
          row.peer_name.empty() ? "-" : row.peer_name,
          number(row.ratio(), "-"),
          number(row.goal, "-"),
          truth(row.met, "yes", "NO", "-")};
}

[[nodiscard]] inline std::string json_row(const Row& row) {
  std::ostringstream out;
  out << "{\"case\": " << quoted(row.case_name) << ", \"metric\": " << quoted(row.metric)
      << ", \"unit\": " << quoted(row.unit) << ", \"ours\": " << number(row.ours, "null")
      << ", \"peer\": " << number(row.peer, "null")
      << ", \"peer_name\": " << (row.peer_name.empty() ? "null" : quoted(row.peer_name))
      << ", \"ratio\": " << number(row.ratio(), "null") << ", \"goal\": " << number(row.goal, "null")
      << ", \"met\": " << truth(row.met, "true", "false", "null") << "}";
  return out.str();
}

}  // namespace detail

/// Table for people: texts left, numbers right aligned.
inline void print_table(std::ostream& out, const std::vector<Row>& rows) {
  std::vector<detail::Line> lines{
      {"case", "metric", "unit", "ours", "peer", "peer name", "ratio", "goal", "met"}};
  for (const auto& row : rows) lines.push_back(detail::table_line(row));
  std::array<std::size_t, detail::kColumns> width{};
  for (const auto& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) width[c] = std::max(width[c], line[c].size());
  constexpr std::array<bool, detail::kColumns> kRight{false, false, false, true, true,
                                                      false, true,  true,  false};
  for (const auto& line : lines) {
    std::string text;
    for (std::size_t c = 0; c < line.size(); ++c) {
      const std::string gap(width[c] - line[c].size(), ' ');
      text += (kRight[c] ? gap + line[c] : line[c] + gap) + "  ";
    }
    text.erase(text.find_last_not_of(' ') + 1);
    out << text << '\n';
  }
}

/// {"name", "machine", "rows": [{"case", "metric", "unit", "ours", "peer", "peer_name", "ratio", "goal",
/// "met"}]}. False when the file cannot be written.
[[nodiscard]] inline bool write_json(const std::string& file, const std::string& name,
                                     const std::vector<Row>& rows) {
  std::ofstream out(file);
  out << "{\"name\": " << detail::quoted(name) << ", \"machine\": " << detail::quoted(machine_description())
      << ", \"rows\": [";
  for (std::size_t i = 0; i < rows.size(); ++i) out << (i ? ",\n  " : "\n  ") << detail::json_row(rows[i]);
  out << "\n]}\n";
  out.close();
  return !out.fail();
}

}  // namespace extperfc::benchmark
