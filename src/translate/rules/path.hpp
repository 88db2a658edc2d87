#pragma once

#include <string>

#include "extperfc/translate/rules.hpp"

namespace extperfc::translate {

/// Reads "claimed_resources[0].hardware_interface". The error says what is wrong with the text.
[[nodiscard]] Result<Path> parse_path(const std::string& text);

/// Where a path ends.
struct PathEnd {
  const Field* field{nullptr};
  const MessageSchema* owner{nullptr};  ///< the message that `field` is in
  bool element{false};                  ///< one element of an array
};
/// Follows a path from a message. The error names the step, and the nearest field when there is no such one.
[[nodiscard]] Result<PathEnd> resolve(const Path& path, const MessageSchema& root);

/// Numbers that can be scaled: all but bool.
[[nodiscard]] constexpr bool is_arithmetic(Primitive primitive) {
  return primitive >= Primitive::kInt8 && primitive <= Primitive::kFloat64;
}
[[nodiscard]] std::vector<std::string> field_names(const MessageSchema& schema);

}  // namespace extperfc::translate
