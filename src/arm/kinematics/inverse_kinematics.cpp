#include "extperfc/arm/inverse_kinematics.hpp"

#include "arm/kinematics/check.hpp"
#include "arm/kinematics/reach.hpp"
#include "arm/kinematics/solver.hpp"

namespace extperfc::arm {
namespace {

bool is_usable(const IkOptions& options) {
  return is_usable(options.tolerance) && options.timeout_s >= 0 && options.max_restarts >= 0;
}

}  // namespace

const char* to_string(IkReason reason) {
  switch (reason) {
    case IkReason::kInvalid:
      return "invalid";
    case IkReason::kOutOfReach:
      return "out_of_reach";
    case IkReason::kLimits:
      return "limits";
    case IkReason::kCollision:
      return "collision";
    case IkReason::kTimeout:
      return "timeout";
  }
  return "unknown";
}

InverseKinematics::InverseKinematics(ArmChain chain) : chain_(std::move(chain)) {}

IkResult InverseKinematics::solve(const Pose& target, const JointVector& seed,
                                  const IkOptions& options) const {
  if (!is_rigid(target) || !is_usable(chain_, seed) || !is_usable(options))
    return tl::unexpected(invalid_failure());
  const bool beyond = is_beyond(chain_.geometry().reach, target, options.tolerance);
  return with_size(chain_.joint_count(), [&](auto size) {
    return Solver<size()>(chain_, target, options).solve(Joints<size()>(seed), beyond);
  });
}

IkResult InverseKinematics::solve(const KDL::Frame& target, const KDL::JntArray& seed,
                                  const IkOptions& options) const {
  if (seed.rows() != static_cast<unsigned>(chain_.joint_count())) return tl::unexpected(invalid_failure());
  return solve(from_kdl(target), from_kdl(seed), options);
}

}  // namespace extperfc::arm
