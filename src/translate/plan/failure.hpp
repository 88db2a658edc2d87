#pragma once

#include <cstdint>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::translate {

/// Why a conversion stopped. Filled on failure only.
struct Failure {
  enum class Kind : std::uint8_t {
    kNone,
    kEnds,      ///< the bytes end early
    kTrailing,  ///< bytes are left
    kCount,     ///< more elements than the bytes left can hold
    kTooLong,   ///< the converted message exceeds its bound
    kValue,     ///< a value does not fit
    kLength,    ///< an array has not the length that the target's has
    kIndex,     ///< an array is shorter than a rule needs
  };
  Kind kind{Kind::kNone};
  std::string path;   ///< with indices
  std::string value;  ///< that does not fit
  std::uint64_t number{0};
  std::uint64_t limit{0};
};
[[nodiscard]] Error to_error(const Failure& failure);

}  // namespace extperfc::translate
