#pragma once

#include <string>

#include <tl/expected.hpp>

#include "extperfc/arm/arm_code.hpp"

namespace extperfc::arm_node {

/// How something ended, as results of actions carry it.
struct Ending {
  arm::ArmCode code{arm::ArmCode::kInternal};
  std::string message;
};

[[nodiscard]] inline tl::unexpected<Ending> end(arm::ArmCode code, std::string message) {
  return tl::unexpected<Ending>(Ending{code, std::move(message)});
}

}  // namespace extperfc::arm_node
