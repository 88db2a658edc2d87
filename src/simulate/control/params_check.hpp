#pragma once

#include "extperfc/simulate/simulator.hpp"

namespace extperfc::simulate {

/// An error with a line per value that is out of its range. Bodies::make checks its own.
[[nodiscard]] Result<void> check(const SimulatorParams& params);

}  // namespace extperfc::simulate
