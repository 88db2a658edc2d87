#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extperfc/translate/plan.hpp"

/// A slow converter that shares nothing with plans: bytes become a tree of values, the tree is paired by
/// names with the target's definition, and the result is written as bytes again.
namespace extperfc::translate::reference {

struct Value {
  std::string bytes;         ///< of a number, stamp or string (without its length)
  std::vector<Value> parts;  ///< of an array its elements, of a message its fields
};

/// Nothing when the bytes end early; `rest` loses what was read.
[[nodiscard]] std::optional<Value> decode(const MessageSchema& schema, std::string& rest);
void encode(const MessageSchema& schema, const Value& value, std::string& out);

/// Nothing when the bytes do not fit the definition, or a value does not fit the target.
[[nodiscard]] std::optional<std::string> convert(const MessageSchema& from, const MessageSchema& to,
                                                 const std::string& message, const PlanOptions& options,
                                                 std::int64_t shift_ns);

}  // namespace extperfc::translate::reference
