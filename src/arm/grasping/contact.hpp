#pragma once

#include <optional>

#include <Eigen/Core>

#include "extperfc/arm/parallel_hand.hpp"
#include "extperfc/world/pose.hpp"

#include "arm/collision/convex_part.hpp"

namespace extperfc::arm {

/// What fingers meet when they close on a part.
struct PadContact {
  double half_width_m{0};  ///< from the middle plane to the pads when they hold
  double lean_rad{0};      ///< of the surface against the pads' normal
  double overlap_x_m{0};   ///< extent of what is between the pads, along x and z of the tip
  double overlap_z_m{0};
  double fraction{0};  ///< of the pad's area that lies against the part within 0.5 mm
};

/// For a tip at `part_T_tip` (the part's frame) and a part that is its own mirror image in the tip's plane
/// y = 0. Nothing when there is nothing between the pads. A grid of 17 x 17 lines through the pad.
[[nodiscard]] std::optional<PadContact> contact_of(const ParallelHand& hand, const ConvexPart& part,
                                                   const Pose& part_T_tip);

/// How far the whole part reaches from the tip's plane y = 0.
[[nodiscard]] double half_extent_m(const ConvexPart& part, const Pose& part_T_tip);

/// How far from the middle plane the part reaches where fingers pass on their path to the tip's pose, less
/// how far each piece of the finger lies behind the pad; 0 when they pass nothing.
[[nodiscard]] double passage_half_width_m(const ParallelHand& hand, const ConvexPart& part,
                                          const Pose& part_T_tip);

/// Height in the root frame of the lowest point of the open hand [m].
[[nodiscard]] double lowest_z_m(const ParallelHand& hand, const Pose& root_T_tip, double opening_m);

/// The pad's middle in the tip's frame, between both pads.
[[nodiscard]] Eigen::Vector3d pad_middle(const ParallelHand& hand);

}  // namespace extperfc::arm
