#pragma once

#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// Address of `symbol` in the shared library lib<library>.so, which is loaded now if it was not before and
/// stays loaded. For parts that cost much memory and are seldom needed. `neighbour` is the address of any
/// function or constant of the asking library: its folder is looked at first, the system's search path then.
/// kUnsupported with the linker's reason when the library or the symbol is not there. Any thread.
[[nodiscard]] Result<void*> late_symbol(const std::string& library, const std::string& symbol,
                                        const void* neighbour);

}  // namespace extperfc
