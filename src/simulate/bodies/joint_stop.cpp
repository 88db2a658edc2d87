#include "simulate/bodies/joint_stop.hpp"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

namespace extperfc::simulate {
namespace {

/// Fraction of the distance back that a joint beyond its end takes in one step.
constexpr double kReturn = 0.2;

}  // namespace

JointStop::JointStop(btMultiBody& body, int link, double lower, double upper, double nearby)
    : btMultiBodyConstraint(&body, &body, link, body.getLink(link).m_parent, 2, true,
                            MULTIBODY_CONSTRAINT_LIMIT),
      lower_(lower),
      upper_(upper),
      nearby_(nearby) {
  m_maxAppliedImpulse = 1e6;
}

void JointStop::finalizeMultiDof() {
  allocateJacobiansMultiDof();
  const int column = 6 + m_bodyA->getLink(m_linkA).m_dofOffset;
  jacobianA(0)[column] = 1;
  jacobianA(1)[column] = -1;
  m_numDofsFinalized = m_jacSizeBoth;
}

int JointStop::getIslandIdA() const {
  const btMultiBodyLinkCollider* const collider = m_bodyA->getLink(m_linkA).m_collider;
  return collider == nullptr ? -1 : collider->getIslandTag();
}

void JointStop::createConstraintRows(btMultiBodyConstraintArray& rows, btMultiBodyJacobianData& data,
                                     const btContactSolverInfo& info) {
  const double position = m_bodyA->getJointPos(m_linkA);
  const double left[2] = {position - lower_, upper_ - position};  // distance to each end
  for (int end = 0; end < 2; ++end) {
    if (left[end] > nearby_) continue;
    btMultiBodySolverConstraint& row = rows.expandNonInitializing();
    row.m_orgConstraint = this;
    row.m_orgDofIndex = end;
    const double slowest = -left[end] / info.m_timeStep * (left[end] < 0 ? kReturn : 1);
    const btVector3 none(0, 0, 0);
    fillMultiBodyConstraint(row, data, jacobianA(end), jacobianB(end), none, none, none, none, 0, info, 0,
                            m_maxAppliedImpulse, false, 1, false, slowest);
  }
}

}  // namespace extperfc::simulate
