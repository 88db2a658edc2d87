#pragma once

#include <string>
#include <vector>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/kinematics.hpp"
#include "extperfc/base/error.hpp"

namespace extperfc::arm {

/// Which joints of a group are those of one arm.
class ArmInGroup {
 public:
  /// Errors: a joint of the chain that is not in the group.
  [[nodiscard]] static Result<ArmInGroup> make(const ArmChain& chain,
                                               const std::vector<std::string>& group_joints);

  [[nodiscard]] const ArmChain& chain() const { return chain_; }
  [[nodiscard]] int joint_count() const { return chain_.joint_count(); }
  /// Of the chain's joints in the group.
  [[nodiscard]] const std::vector<int>& places() const { return places_; }
  /// The arm's part of a vector of the group.
  [[nodiscard]] JointVector take(const JointVector& group) const;
  /// `group` with the arm's part replaced.
  [[nodiscard]] JointVector put(const JointVector& arm, JointVector group) const;

 private:
  ArmInGroup(ArmChain chain, std::vector<int> places)
      : chain_(std::move(chain)), places_(std::move(places)) {}

  ArmChain chain_;
  std::vector<int> places_;
};

}  // namespace extperfc::arm
