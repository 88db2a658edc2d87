#pragma once

#include "extperfc/arm/status.hpp"

namespace extperfc::ros_arm {

using arm::failure;
using arm::Status;

}  // namespace extperfc::ros_arm
