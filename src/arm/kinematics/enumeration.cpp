#include "arm/kinematics/enumeration.hpp"

#include "arm/kinematics/descent.hpp"
#include "arm/kinematics/self_motion.hpp"

namespace extperfc::arm::ik {
namespace {

constexpr double kSame = 1e-3;      // [rad]; the tolerance's image at a nearly singular position
constexpr double kOnBranch = 0.75;  // of a step: half of one and what curvature adds
constexpr int kMaxSteps = 2000;

}  // namespace

Enumeration::Enumeration(const ArmChain& chain, const Pose& target, const IkSearchOptions& options)
    : chain_(chain),
      options_(options),
      task_(target, options.tolerance, chain.geometry()),
      bounds_(bounds_of<Eigen::Dynamic>(chain)),
      draws_(bounds_, options.rng_seed),
      deadline_(options.timeout_s),
      redundancy_(SelfMotion::redundancy(chain.joint_count(), options.tolerance)) {}

IkSolutionSet Enumeration::run(const JointVector& seed) {
  Descent<Eigen::Dynamic> descent(chain_.geometry(), task_, bounds_);
  JointVector q = bounds_.clamp(seed);
  IkSolutionSet found;
  int known = 0;
  for (int i = 0; i < options_.max_descents && !deadline_.passed(); ++i, q = draws_.next()) {
    if (!descent.run(q, deadline_)) continue;
    unwind(bounds_, seed, q);
    if (!is_new(found, q)) {
      found.complete = ++known >= options_.patience;
      if (found.complete) break;
      continue;
    }
    known = 0;
    found.branches.push_back(branch(q));
    if (static_cast<int>(found.branches.size()) >= options_.max_branches) break;
  }
  return found;
}

bool Enumeration::is_new(const IkSolutionSet& found, const JointVector& q) const {
  const double part = redundancy_ > 1 ? 1 : kOnBranch;
  const double radius = redundancy_ > 0 ? part * options_.step_rad : kSame;
  for (const IkBranch& branch : found.branches)
    for (const JointVector& joints : branch.joints)
      if (chain_.difference(q, joints).squaredNorm() < radius * radius) return false;
  return true;
}

IkBranch Enumeration::branch(const JointVector& q) const {
  if (redundancy_ != 1) return {{q}, false};
  return SelfMotion(chain_, q, options_.tolerance, options_.step_rad).trace(kMaxSteps);
}

}  // namespace extperfc::arm::ik
