#pragma once

#include <string_view>

namespace extperfc::sources {

/// Order of file names that people expect: runs of digits compare as numbers, so "2" comes before "10". A
/// strict weak order; names that differ only in leading zeros compare as text.
[[nodiscard]] bool natural_less(std::string_view a, std::string_view b);

}  // namespace extperfc::sources
