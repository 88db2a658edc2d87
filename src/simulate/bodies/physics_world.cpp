#include "simulate/bodies/physics_world.hpp"

namespace extperfc::simulate {

PhysicsWorld::PhysicsWorld(const BodiesParams& params)
    : step_s_(params.step_s),
      dispatcher_(&configuration_),
      world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
  world_.setGravity({0, 0, -params.gravity_m_s2});
  world_.setForceUpdateAllAabbs(false);  // what does not move keeps its box
  world_.getDispatchInfo().m_deterministicOverlappingPairs = true;
  world_.getDispatchInfo().m_allowedCcdPenetration =
      1e-4;  // its default of 4 cm lets small objects through boards
  btContactSolverInfo& info = world_.getSolverInfo();
  info.m_numIterations = params.solver_iterations;
  info.m_minimumSolverBatchSize =
      1;  // islands are solved apart, so what happens in one leaves others as they are
  info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
  info.m_splitImpulsePenetrationThreshold = 0;  // an overlap that is pushed apart adds no speed
  info.m_globalCfm = 1e-6;
  info.m_restitutionVelocityThreshold = 0.1;
  solver_.setRandSeed(0);
}

void PhysicsWorld::set_contacts(const btCollisionObject& link, btRigidBody& body, bool on) {
  body.setIgnoreCollisionCheck(&link, !on);
  world_.getPairCache()->cleanProxyFromPairs(body.getBroadphaseHandle(), &dispatcher_);
  body.activate(true);
}

}  // namespace extperfc::simulate
