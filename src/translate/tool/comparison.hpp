#pragma once

#include <string>
#include <vector>

#include "extperfc/translate/plan.hpp"
#include "extperfc/translate/rules.hpp"

#include "translate/tool/type_definitions.hpp"

namespace extperfc::translate {

enum class Verdict : unsigned char {
  kSame,       ///< one definition on both sides
  kPass,       ///< constants differ: the bytes are forwarded untouched
  kConvert,    ///< there is a plan, in both directions
  kNeedsRule,  ///< fields do not convert, in at least one direction
  kUnknown,    ///< a definition or an MD5 is not known
};
[[nodiscard]] const char* to_string(Verdict verdict);

/// One type whose definitions were compared.
struct Row {
  std::string robot_type, workstation_type,
      kind;                                ///< the types differ when a rule renames the one to the other
  std::string robot_md5, workstation_md5;  ///< empty: not known
  Verdict verdict{Verdict::kUnknown};
  bool by_rule{false};               ///< a rule has part in it
  std::vector<std::string> reasons;  ///< why it needs a rule, or what is not known
  std::vector<std::string> added, dropped,
      ruled;  ///< fields, from robot to workstation: defaults, left out, by a rule
  std::string robot_where, workstation_where;  ///< topics and services, of running masters
};

struct Comparison {
  std::vector<Row> rows;     ///< by type and kind
  std::vector<Row> renamed;  ///< those that have another name on the workstation side
  std::size_t only_robot{0}, only_workstation{0};
};

/// Compares all types that both sides have; for types with several definitions every pair.
[[nodiscard]] Comparison compare(const TypeSet& robot, const TypeSet& workstation, const RuleSet& rules);

}  // namespace extperfc::translate
