#pragma once

#include <string>

#include "extperfc/arm/arm_code.hpp"

namespace extperfc::arm {

/// How a request or a motion ended, as the results of the actions report it.
struct Status {
  ArmCode code{ArmCode::kInternal};
  std::string message;
};

}  // namespace extperfc::arm
