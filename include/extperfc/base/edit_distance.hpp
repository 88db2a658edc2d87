#pragma once

#include <cstddef>
#include <string_view>

namespace extperfc {

/// How many characters must be inserted, removed or replaced to turn one token into the other (Levenshtein).
/// For hints to people who mistyped a name; takes the product of both lengths.
[[nodiscard]] std::size_t edit_distance(std::string_view from, std::string_view to);

}  // namespace extperfc
