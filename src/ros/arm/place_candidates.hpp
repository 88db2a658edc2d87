#pragma once

#include <vector>

#include "extperfc/arm/grasp.hpp"

#include "ros/arm/scene_keeper.hpp"

namespace extperfc::arm_node {

/// Ways to put the thing down as the request wants it. A ball stands in any orientation: for it also ways on
/// which the hand comes from straight down to nearly level. Errors: those of arm::place_poses().
[[nodiscard]] Result<std::vector<arm::PlaceCandidate>> place_candidates(const arm::ParallelHand& hand,
                                                                        const SceneItem& item,
                                                                        const arm::PlaceRequest& request,
                                                                        const arm::PlaceParams& params);

}  // namespace extperfc::arm_node
