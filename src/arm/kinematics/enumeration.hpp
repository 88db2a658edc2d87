#pragma once

#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/draws.hpp"

namespace extperfc::arm::ik {

/// Random descents; each solution that lies on no known branch starts one.
class Enumeration {
 public:
  Enumeration(const ArmChain& chain, const Pose& target, const IkSearchOptions& options);

  /// Branches in the order they were found, regardless of options.accept; empty when no descent reached the
  /// target.
  [[nodiscard]] IkSolutionSet run(const JointVector& seed);

 private:
  [[nodiscard]] bool is_new(const IkSolutionSet& found, const JointVector& q) const;
  [[nodiscard]] IkBranch branch(const JointVector& q) const;

  const ArmChain& chain_;
  const IkSearchOptions& options_;
  Task task_;
  AnyBounds bounds_;
  Draws<Eigen::Dynamic> draws_;
  Deadline deadline_;
  int redundancy_;
};

}  // namespace extperfc::arm::ik
