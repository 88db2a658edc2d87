#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Parts of messages for people.
namespace extperfc {

/// How many characters must be inserted, removed or replaced to turn one token into the other (Levenshtein).
/// For hints to people who mistyped a name; takes the product of both lengths.
[[nodiscard]] std::size_t edit_distance(std::string_view from, std::string_view to);

/// ", did you mean "..."?" with the known name that is nearest to `name`; empty when none is near.
[[nodiscard]] std::string hint_for(const std::string& name, const std::vector<std::string>& known);
/// The hint, or ": known are a, b and c" without one.
[[nodiscard]] std::string hint_or_names(const std::string& name, const std::vector<std::string>& known);

/// "a, b, c".
[[nodiscard]] std::string joined(const std::vector<std::string>& names, const std::string& between = ", ");
/// "a, b and c"; "none" for none.
[[nodiscard]] std::string enumeration(const std::vector<std::string>& names,
                                      const std::string& last = " and ");

/// Text of a stranger for a message: in quotes, shortened, without control characters.
[[nodiscard]] std::string in_quotes(const std::string& text);

[[nodiscard]] bool ends_with(std::string_view text, std::string_view end);

}  // namespace extperfc
