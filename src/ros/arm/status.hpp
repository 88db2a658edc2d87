#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

#include "extperfc/arm/status.hpp"

namespace extperfc::arm_node {

using arm::Status;

[[nodiscard]] inline tl::unexpected<Status> failure(arm::ArmCode code, std::string message) {
  return tl::unexpected<Status>(Status{code, std::move(message)});
}

}  // namespace extperfc::arm_node
