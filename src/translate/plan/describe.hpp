#pragma once

#include <string>
#include <vector>

#include "translate/plan/code.hpp"

namespace extperfc::translate {

/// Code as text, one line per step; what belongs to a step is indented below it.
[[nodiscard]] std::vector<std::string> describe_code(const Code& code);

}  // namespace extperfc::translate
