#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/arm/cartesian_path.hpp"

#include "ros/arm/plan_execution.hpp"

namespace extperfc::arm_node {

constexpr double kMinApproach = 0.5;  ///< fraction of approach and descent that is accepted in tight places

/// The callbacks of a part of a motion: its name is reported as the stage.
inline MotionCallbacks with_stage(const MotionCallbacks& callbacks, const char* stage,
                                  std::function<void(arm::CollisionWorld&)> allow) {
  MotionCallbacks changed = callbacks;
  changed.allow = std::move(allow);
  const auto report = callbacks.progress;
  changed.progress = [report, stage](const std::string&, double executed) {
    if (report) report(stage, executed);
  };
  return changed;
}

/// The path that starts at `from`; empty if there is none.
inline std::vector<arm::JointVector> path_from(const std::vector<std::vector<arm::JointVector>>& paths,
                                               const arm::JointVector& from) {
  for (const auto& path : paths)
    if (path.front().isApprox(from, 1e-9)) return path;
  return {};
}

inline arm::JointPositions by_name(const arm::ArmChain& chain, const arm::JointVector& values) {
  arm::JointPositions positions;
  for (std::size_t i = 0; i < chain.joint_names().size(); ++i)
    positions[chain.joint_names()[i]] = values[static_cast<Eigen::Index>(i)];
  return positions;
}

/// Parameters with a small time limit, because many candidates are tried.
inline arm::CartesianParams quick() {
  arm::CartesianParams params;
  params.max_attempts = 4;
  params.timeout_s = 0.1;
  return params;
}

inline Status success() {
  return {arm::ArmCode::kSuccess, ""};
}

inline bool failed(const Status& status) {
  return status.code != arm::ArmCode::kSuccess;
}

inline double or_else(double value, double instead) {
  return value == 0.0 ? instead : value;
}

}  // namespace extperfc::arm_node
