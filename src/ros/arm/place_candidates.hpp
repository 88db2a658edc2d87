#pragma once

#include <vector>

#include "extperfc/arm/grasp.hpp"

#include "ros/arm/planning_scene.hpp"

namespace extperfc::arm_node {

/// Poses that place the object as requested. A ball may rest in any orientation: for it also poses with
/// approaches from vertical to nearly horizontal. Errors: those of arm::place_poses().
[[nodiscard]] Result<std::vector<arm::PlaceCandidate>> place_candidates(const arm::ParallelHand& hand,
                                                                        const CollisionObject& item,
                                                                        const arm::PlaceRequest& request,
                                                                        const arm::PlaceParams& params);

}  // namespace extperfc::arm_node
