#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "extperfc/arm/arm_code.hpp"

namespace extperfc::arm {

/// How a request or a motion ended, as the results of the actions report it.
struct Status {
  ArmCode code{ArmCode::kInternal};
  std::string message;
};

[[nodiscard]] inline tl::unexpected<Status> failure(ArmCode code, std::string message) {
  return tl::unexpected<Status>(Status{code, std::move(message)});
}

}  // namespace extperfc::arm
