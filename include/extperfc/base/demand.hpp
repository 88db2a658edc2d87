#pragma once

#include <stdexcept>
#include <string>

namespace extperfc {

/// For constructors: throws std::invalid_argument with `what` unless `holds`.
inline void demand(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace extperfc
