#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>

namespace extperfc::simulate {

/// Ends of a joint's range. Unlike Bullet's own limit it acts before the joint has passed its end: a joint
/// that is near may not be faster than what brings it there in one step, so it stops there from any speed.
class JointStop : public btMultiBodyConstraint {
 public:
  /// Ends in [rad] or [m]; `nearby`: how far before an end it begins to act.
  JointStop(btMultiBody& body, int link, double lower, double upper, double nearby);

  void finalizeMultiDof() override;
  [[nodiscard]] int getIslandIdA() const override;
  [[nodiscard]] int getIslandIdB() const override { return getIslandIdA(); }
  void createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                            const btContactSolverInfo& info) override;
  void debugDraw(btIDebugDraw* /*drawer*/) override {}

 private:
  double lower_;
  double upper_;
  double nearby_;
};

}  // namespace extperfc::simulate
