#pragma once

#include <vector>

#include "arm/kinematics/task.hpp"

namespace extperfc::arm::ik {

/// The curve of configurations that hold the tip where `start` has it: steps along the null space of the
/// Jacobian, each corrected by Newton's method (pseudo-arclength continuation; Allgower and Georg,
/// "Introduction to Numerical Continuation Methods", 2003, chapter 2).
class SelfMotion {
 public:
  /// How many degrees of freedom this many joints have beyond the held axes, those of a finite tolerance.
  [[nodiscard]] static int redundancy(int joints, const IkTolerance& held);

  /// The redundancy must be one. `step` > 0: maximum distance between neighbours.
  SelfMotion(const ArmChain& chain, const JointVector& start, const IkTolerance& held, double step);

  /// At most `max_steps` steps in each direction.
  [[nodiscard]] IkBranch trace(int max_steps);

 private:
  void evaluate(const JointVector& q);
  [[nodiscard]] JointVector first_heading();
  [[nodiscard]] JointVector heading_at(const JointVector& q, const JointVector& last);
  [[nodiscard]] bool correct(JointVector& q);
  [[nodiscard]] bool advance(const JointVector& q, const JointVector& heading, double length,
                             JointVector& next);
  [[nodiscard]] bool walk(JointVector heading, int max_steps, std::vector<JointVector>& out);
  [[nodiscard]] bool passes_start(const JointVector& q, const JointVector& heading, double length) const;
  void to_limit(const JointVector& q, const JointVector& heading, double length,
                std::vector<JointVector>& out);

  const Geometry& geometry_;
  AnyBounds bounds_;
  Task task_;
  JointVector start_;
  double step_;
  AnyEvaluation here_;
  Jacobian columns_;
};

}  // namespace extperfc::arm::ik
