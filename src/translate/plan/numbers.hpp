#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "extperfc/translate/schema.hpp"

#include "translate/plan/code.hpp"

/// Numbers of one primitive as another, on little-endian bytes without alignment.
namespace extperfc::translate {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

[[nodiscard]] constexpr bool is_number(Primitive primitive) {
  return primitive <= Primitive::kFloat64;
}

/// Converts `count` numbers. Returns how many fitted: fewer than `count` when the next one does not. Floating
/// point to integer rounds to the nearest; NaN fits floating point alone. With `saturate` all but NaN fit.
[[nodiscard]] std::size_t convert_numbers(Primitive from, Primitive to, bool saturate,
                                          const std::uint8_t* source, std::uint8_t* target,
                                          std::size_t count);
/// The same of number * factor + offset, computed in double precision.
[[nodiscard]] std::size_t scale_numbers(Primitive from, Primitive to, bool saturate, const Scale& scale,
                                        const std::uint8_t* source, std::uint8_t* target, std::size_t count);
/// The number as text, e.g. "300".
[[nodiscard]] std::string number_text(Primitive primitive, const std::uint8_t* bytes);

}  // namespace extperfc::translate
