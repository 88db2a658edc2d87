#pragma once

#include <vector>

#include <kdl/chain.hpp>

#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

/// One segment per joint, in this order; a joint's axis is given in the frame of its parent link.
[[nodiscard]] KDL::Chain kdl_chain(const RobotModel& robot, const std::vector<int>& joints);

}  // namespace extperfc::arm
