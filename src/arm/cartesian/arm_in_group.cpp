#include "arm/cartesian/arm_in_group.hpp"

#include <algorithm>
#include <cstddef>

namespace extperfc::arm {

Result<ArmInGroup> ArmInGroup::make(const ArmChain& chain, const std::vector<std::string>& group_joints) {
  std::vector<int> places;
  for (const auto& name : chain.joint_names()) {
    const auto found = std::find(group_joints.begin(), group_joints.end(), name);
    if (found == group_joints.end())
      return fail(ErrorCode::kInvalidArgument, "link " + chain.tip_link() + " is moved by " + name +
                                                   ", which is not a joint of the group");
    places.push_back(static_cast<int>(found - group_joints.begin()));
  }
  return ArmInGroup(chain, std::move(places));
}

JointVector ArmInGroup::take(const JointVector& group) const {
  JointVector arm(joint_count());
  for (std::size_t j = 0; j < places_.size(); ++j) arm[static_cast<int>(j)] = group[places_[j]];
  return arm;
}

JointVector ArmInGroup::put(const JointVector& arm, JointVector group) const {
  for (std::size_t j = 0; j < places_.size(); ++j) group[places_[j]] = arm[static_cast<int>(j)];
  return group;
}

}  // namespace extperfc::arm
