#pragma once

#include <bitset>
#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::scan {

/// Lasers whose points count. Rings from 256 on never do.
using RingSet = std::bitset<256>;

/// Reads "7", "4-11" or "1,3,8-15"; spaces do not matter, and "" selects no ring.
[[nodiscard]] Result<RingSet> parse_rings(const std::string& text);

}  // namespace extperfc::scan
