#pragma once

#include "arm/kinematics/descent.hpp"

namespace extperfc::arm {

/// sum of weight (q - centre)^2
struct Objective {
  JointVector centre, weight;  ///< weight > 0

  [[nodiscard]] double value(const JointVector& q) const {
    return (weight.array() * (q - centre).array().square()).sum();
  }
};

[[nodiscard]] Objective near(const JointVector& seed);
/// In half ranges; joints without end have next to no weight.
[[nodiscard]] Objective mid_range(const ArmChain& chain);

/// Moves a solution along the task's null space to a local minimum of an objective: sequential quadratic
/// programming with the equalities J d = -residual and the box as an active set (Nocedal and Wright,
/// "Numerical Optimization", 2006, chapter 18), every step corrected onto the task by a descent.
class Settle {
 public:
  /// Keeps references to all three.
  Settle(const ChainGeometry& geometry, const Task& task, const AnyBounds& bounds)
      : geometry_(geometry), task_(task), bounds_(bounds), descent_(geometry, task, bounds) {}

  /// `q` must be in the box and fulfil the task; it still does so afterwards and its value is no larger.
  void run(JointVector& q, const Objective& objective, const Deadline& deadline);

 private:
  [[nodiscard]] JointVector direction(const JointVector& q, const Objective& objective);
  [[nodiscard]] bool block(const JointVector& q, const JointVector& change, JointVector& wish);
  [[nodiscard]] double longest_step(const JointVector& q, const JointVector& change) const;
  [[nodiscard]] bool advance(JointVector& q, const JointVector& change, const Objective& objective,
                             const Deadline& deadline);

  const ChainGeometry& geometry_;
  const Task& task_;
  const AnyBounds& bounds_;
  Descent<Eigen::Dynamic> descent_;
  AnyEvaluation here_;
  Jacobian columns_;
};

}  // namespace extperfc::arm
