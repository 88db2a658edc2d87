#pragma once

#include <cstdlib>
#include <iostream>
#include <utility>

#include "extperfc/base/error.hpp"

namespace extperfc::examples {

/// The value of a result; a failed one ends the program with its message.
template <typename T>
T value_of(Result<T> result) {
  if (result) return std::move(*result);
  std::cerr << result.error().message << "\n";
  std::exit(1);
}

inline void check(const Result<void>& result) {
  if (result) return;
  std::cerr << result.error().message << "\n";
  std::exit(1);
}

}  // namespace extperfc::examples
