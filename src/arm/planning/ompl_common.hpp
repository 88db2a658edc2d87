#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>

#include "extperfc/arm/joint_vector.hpp"
#include "extperfc/arm/kinematics.hpp"

/// What the planners of OMPL have in common, with constraints and without.
namespace extperfc::arm {

/// OMPL's random numbers are seeded once per process; it writes no log.
void seed_ompl_once(std::uint64_t seed);

[[nodiscard]] std::shared_ptr<ompl::base::RealVectorStateSpace> bounded_space(const JointLimits& limits);

/// `write` puts joint values into a state of the space.
[[nodiscard]] ompl::base::ProblemDefinitionPtr make_problem(
    const ompl::base::SpaceInformationPtr& space, const JointVector& start,
    const std::vector<JointVector>& goals,
    const std::function<void(const JointVector&, ompl::base::State*)>& write);

template <typename Makers>
[[nodiscard]] std::vector<std::string> names_of(const Makers& makers) {
  std::vector<std::string> names;
  names.reserve(makers.size());
  for (const auto& [name, maker] : makers) names.push_back(name);
  return names;
}

}  // namespace extperfc::arm
