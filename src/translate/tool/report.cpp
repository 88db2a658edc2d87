#include "translate/tool/report.hpp"

#include <algorithm>
#include <array>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

namespace extperfc::translate {
namespace {

constexpr std::size_t kShortMd5 = 8;

std::string short_md5(const std::string& md5) {
  return md5.empty() ? "?" : md5.substr(0, kShortMd5);
}

std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text;
}

bool shown(const Row& row, const ReportOptions& options) {
  return options.all || row.verdict != Verdict::kSame;
}

const char* summary(const Row& row) {
  if (row.verdict == Verdict::kPass) return "constants only";
  if (row.verdict != Verdict::kConvert) return "";
  return row.by_rule ? "by rule" : "by name";
}

struct Counts {
  std::array<std::size_t, 5> of{};
  explicit Counts(const std::vector<Row>& rows) {
    for (const auto& row : rows) ++of.at(static_cast<std::size_t>(row.verdict));
  }
  [[nodiscard]] std::size_t different() const {
    return (*this)[Verdict::kPass] + (*this)[Verdict::kConvert] + (*this)[Verdict::kNeedsRule] +
           (*this)[Verdict::kUnknown];
  }
  [[nodiscard]] std::string as_text() const {
    return std::to_string((*this)[Verdict::kPass]) + " pass, " + std::to_string((*this)[Verdict::kConvert]) +
           " convert, " + std::to_string((*this)[Verdict::kNeedsRule]) + " need a rule, " +
           std::to_string((*this)[Verdict::kUnknown]) + " unknown";
  }
  [[nodiscard]] std::size_t operator[](Verdict verdict) const {
    return of.at(static_cast<std::size_t>(verdict));
  }
};

void print_fields(std::ostream& out, const char* title, const std::vector<std::string>& fields) {
  std::string text = title;
  for (const auto& field : fields) text += " " + field;
  if (!fields.empty()) out << wrapped(text, "    ");
}

void print_details(std::ostream& out, const Row& row, bool with_fields) {
  if (with_fields) {
    print_fields(out, "rule:", row.ruled);
    print_fields(out, "default:", row.added);
    print_fields(out, "left out:", row.dropped);
  }
  for (const auto& reason : row.reasons) out << wrapped(reason, "    ");
  if (!row.robot_where.empty()) out << wrapped("robot: " + row.robot_where, "    ");
  if (!row.workstation_where.empty()) out << wrapped("workstation: " + row.workstation_where, "    ");
}

}  // namespace

bool all_well(const Comparison& comparison) {
  const auto well = [](const Row& row) {
    return row.verdict != Verdict::kNeedsRule && row.verdict != Verdict::kUnknown;
  };
  return std::all_of(comparison.rows.begin(), comparison.rows.end(), well) &&
         std::all_of(comparison.renamed.begin(), comparison.renamed.end(), well);
}

std::string wrapped(const std::string& text, const std::string& indent) {
  std::istringstream tokens(text);
  std::string lines;
  std::string line = indent;
  for (std::string token; tokens >> token;) {
    for (const auto width = kColumns - indent.size() - 2; token.size() > width; token.erase(0, width)) {
      if (line.size() > indent.size()) lines += line + "\n";
      lines += indent + "  " + token.substr(0, width) + "\n";
      line = indent;
    }
    if (line.size() > indent.size() && line.size() + 1 + token.size() > kColumns) {
      lines += line + "\n";
      line = indent + "  ";
    } else if (line.size() > indent.size()) {
      line += " ";
    }
    line += token;
  }
  return lines + line + "\n";
}

namespace {

class Table {
 public:
  Table(std::ostream& out, const ReportOptions& options) : out_(out), options_(options) {}

  void print(const std::vector<Row>& rows) {
    std::size_t width = kMinType;
    bool any = false;
    for (const auto& row : rows) {
      if (!shown(row, options_)) continue;
      any = true;
      width = std::max(width, std::min(row.robot_type.size(), kMaxType));
    }
    if (!any) return;
    out_ << padded("type", width) << " kind   robot    workst.  verdict      what\n"
         << std::string(kColumns, '-') << "\n";
    for (const auto& row : rows)
      if (shown(row, options_)) print(row, width);
  }

 private:
  static constexpr std::size_t kMinType = 30;
  static constexpr std::size_t kMaxType = 46;

  void print(const Row& row, std::size_t width) {
    auto line = padded(row.robot_type, width);
    if (line.size() > width) line += "\n" + std::string(width, ' ');
    line += " " + padded(row.kind, 6) + " " + padded(short_md5(row.robot_md5), kShortMd5) + " " +
            padded(short_md5(row.workstation_md5), kShortMd5) + " " + padded(to_string(row.verdict), 12) +
            " " + summary(row);
    out_ << line.substr(0, line.find_last_not_of(' ') + 1) << "\n";
    if (row.robot_type != row.workstation_type)
      out_ << "    is " << row.workstation_type << " on the workstation side\n";
    print_details(out_, row, options_.fields);
  }

  std::ostream& out_;
  const ReportOptions& options_;
};

}  // namespace

void print_table(std::ostream& out, const Comparison& comparison, const ReportOptions& options) {
  out << "robot: " << options.robot_name << "\nworkstation: " << options.workstation_name << "\n\n";
  Table table(out, options);
  table.print(comparison.rows);
  const Counts counts(comparison.rows);
  const Counts renamed(comparison.renamed);
  if (renamed.different() != 0 || (options.all && !comparison.renamed.empty())) {
    out << "\nrenamed:\n";
    table.print(comparison.renamed);
  }
  out << "\n"
      << counts.different() << " differ: " << counts.as_text() << "; " << counts[Verdict::kSame]
      << " are the same\n";
  if (!comparison.renamed.empty())
    out << comparison.renamed.size() << " have another name: " << renamed.as_text() << ", "
        << renamed[Verdict::kSame] << " the same\n";
  out << comparison.only_robot << " only robot, " << comparison.only_workstation << " only workstation\n";
}

namespace {

nlohmann::json rows_json(const std::vector<Row>& rows, const ReportOptions& options) {
  auto json = nlohmann::json::array();
  for (const auto& row : rows)
    if (shown(row, options))
      json.push_back({{"robot_type", row.robot_type},
                      {"workstation_type", row.workstation_type},
                      {"kind", row.kind},
                      {"robot_md5", row.robot_md5},
                      {"workstation_md5", row.workstation_md5},
                      {"verdict", to_string(row.verdict)},
                      {"by_rule", row.by_rule},
                      {"rule", row.ruled},
                      {"default", row.added},
                      {"left_out", row.dropped},
                      {"reasons", row.reasons},
                      {"robot_where", row.robot_where},
                      {"workstation_where", row.workstation_where}});
  return json;
}

}  // namespace

void print_json(std::ostream& out, const Comparison& comparison, const ReportOptions& options) {
  const Counts counts(comparison.rows);
  const nlohmann::json json{{"robot", options.robot_name},
                            {"workstation", options.workstation_name},
                            {"types", rows_json(comparison.rows, options)},
                            {"renamed", rows_json(comparison.renamed, options)},
                            {"counts",
                             {{"same", counts[Verdict::kSame]},
                              {"pass", counts[Verdict::kPass]},
                              {"convert", counts[Verdict::kConvert]},
                              {"needs a rule", counts[Verdict::kNeedsRule]},
                              {"unknown", counts[Verdict::kUnknown]},
                              {"only_robot", comparison.only_robot},
                              {"only_workstation", comparison.only_workstation}}}};
  out << json.dump(1, ' ', true, nlohmann::json::error_handler_t::replace) << '\n';
}

}  // namespace extperfc::translate
