#pragma once

#include <ostream>
#include <string>

#include "translate/tool/comparison.hpp"

namespace extperfc::translate {

inline constexpr std::size_t kColumns = 100;

struct ReportOptions {
  bool all{false};     ///< with the types that are the same
  bool fields{false};  ///< with the fields that get a default, are left out or come from a rule
  std::string robot_name{"robot"}, workstation_name{"workstation"};
};

/// A table of at most kColumns, one line for each type, reasons below it; counts at the end.
void print_table(std::ostream& out, const Comparison& comparison, const ReportOptions& options);
/// {"robot", "workstation", "types": [...], "renamed": [...], "counts": {...}}.
void print_json(std::ostream& out, const Comparison& comparison, const ReportOptions& options);
/// True when no type needs a rule and none is unknown.
[[nodiscard]] bool all_well(const Comparison& comparison);

/// Breaks at blanks, within kColumns; every line begins with `indent`.
[[nodiscard]] std::string wrapped(const std::string& text, const std::string& indent);

}  // namespace extperfc::translate
