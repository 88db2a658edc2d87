#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/cartesian_path.hpp"

#include "ros/arm/commander.hpp"

namespace extperfc::arm_node {

constexpr double kLeastApproach = 0.5;  ///< share of approach and lowering where there is no room for all

/// The hooks of a part of a motion: its name is reported as the stage.
inline Hooks with(const Hooks& hooks, const char* stage, std::function<void(arm::CollisionWorld&)> allow) {
  Hooks changed = hooks;
  changed.allow = std::move(allow);
  const auto report = hooks.progress;
  changed.progress = [report, stage](const std::string&, double executed) {
    if (report) report(stage, executed);
  };
  return changed;
}

/// The way that starts where another one ended; empty when there is none.
inline std::vector<arm::JointVector> way_on(const std::vector<std::vector<arm::JointVector>>& ways,
                                            const arm::JointVector& from) {
  for (const auto& way : ways)
    if (way.front().isApprox(from, 1e-9)) return way;
  return {};
}

inline arm::JointPositions by_name(const arm::ArmChain& chain, const arm::JointVector& values) {
  arm::JointPositions positions;
  for (std::size_t i = 0; i < chain.joint_names().size(); ++i)
    positions[chain.joint_names()[i]] = values[static_cast<Eigen::Index>(i)];
  return positions;
}

/// Many candidates are tried: none shall cost much.
inline arm::CartesianParams quick() {
  arm::CartesianParams params;
  params.max_attempts = 4;
  params.timeout_s = 0.1;
  return params;
}

inline Ending success() {
  return {arm::ArmCode::kSuccess, ""};
}

inline bool failed(const Ending& ending) {
  return ending.code != arm::ArmCode::kSuccess;
}

inline double or_else(double value, double instead) {
  return value == 0.0 ? instead : value;
}

}  // namespace extperfc::arm_node
