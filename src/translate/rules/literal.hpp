#pragma once

#include <string>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/problems.hpp"
#include "extperfc/translate/rules.hpp"

namespace extperfc::translate {

/// Deepest nesting of what a rule writes, and the most nodes of one file (aliases count wherever they stand):
/// a YAML text of 100 bytes can describe a tree of any size.
inline constexpr int kDeepest = 16;
inline constexpr std::size_t kMaxNodes = 100'000;

/// Counts nodes of one file.
class Budget {
 public:
  /// False when the file is too large; said once.
  [[nodiscard]] bool take(Problems& problems, int line);

 private:
  std::size_t used_{0};
};

/// A literal as it stands: scalars are texts. What has no value (`key:` alone) is a problem.
[[nodiscard]] Literal read_literal(const YAML::Node& node, const std::string& where, Problems& problems,
                                   Budget& budget, int depth = 0);

/// Names of constants (of `owner`, the message that `field` is in) become their values, and YAML's .nan and
/// .inf what the plans understand. The error says why the field cannot hold the value.
[[nodiscard]] Result<Literal> fit(Literal literal, const Field& field, const MessageSchema& owner);

}  // namespace extperfc::translate
