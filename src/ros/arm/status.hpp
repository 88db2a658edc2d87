#pragma once

#include "extperfc/arm/status.hpp"

namespace extperfc::arm_node {

using arm::failure;
using arm::Status;

}  // namespace extperfc::arm_node
