#pragma once

#include <string>

#include "extperfc/translate/rules.hpp"

namespace extperfc::translate {

/// A number, text or truth value as a rule's YAML has it.
[[nodiscard]] inline Literal scalar(const std::string& text) {
  Literal literal;
  literal.scalar = text;
  return literal;
}

}  // namespace extperfc::translate
