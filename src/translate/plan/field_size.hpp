#pragma once

#include <cstddef>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Bytes of an array's count.
inline constexpr std::size_t kCountSize = sizeof(std::uint32_t);

/// A field as one element of it.
[[nodiscard]] Field element_of(const Field& field);
/// The fewest bytes of an element or of a field.
[[nodiscard]] std::size_t min_element_size(const Field& field);
[[nodiscard]] std::size_t min_size(const Field& field);

}  // namespace extperfc::translate
