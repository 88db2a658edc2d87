#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

/// A box of a finger, in the tip's frame: |x| <= x_half_m, z_low_m <= z <= z_high_m. Across, it reaches from
/// `inset_m` behind the pad's face to `inset_m + thickness_m`, away from the other finger.
struct FingerPart {
  double x_half_m{0};
  double z_low_m{0};
  double z_high_m{0};
  double inset_m{0};
  double thickness_m{0};
};

/// A hand with two flat fingers, in the frame of its tip: it approaches along +z, and the fingers close along
/// y, both by the same distance. Baxter's electric grippers have this frame.
struct ParallelHand {
  std::string tip_link;
  double opening_min_m{0};        ///< between the pads when closed; 0 or more
  double opening_max_m{0};        ///< between the pads when open; above opening_min_m, at most 0.5
  std::vector<FingerPart> parts;  ///< of one finger, the other one is its mirror image; first the pad
  Eigen::Vector3d palm_low{Eigen::Vector3d::Zero()};   ///< box of all that carries the fingers [m]
  Eigen::Vector3d palm_high{Eigen::Vector3d::Zero()};  ///< its z is the front of the palm
  std::vector<std::string> finger_links;               ///< links that may touch what is grasped

  /// Errors: a size that cannot be, no pad, a palm in front of the pad's end.
  [[nodiscard]] Result<void> validate() const;
};

/// The hand of a robot, from the collision shapes of its links. `finger_joint` is the prismatic joint that is
/// driven; the other finger's joint mimics it. What reaches across the middle between the fingers counts as
/// palm; the palm is what hangs on the same link as the fingers.
/// Errors: no such link or joint, a joint that is not prismatic along the tip's y axis, no finger that mimics
/// it, fingers that are no mirror images within 1 mm, no shapes.
[[nodiscard]] Result<ParallelHand> hand_of(const RobotModel& robot, const std::string& tip_link,
                                           const std::string& finger_joint);

}  // namespace extperfc::arm
