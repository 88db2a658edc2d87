#pragma once

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "extperfc/arm/inverse_kinematics.hpp"
#include "extperfc/arm/kinematics.hpp"
#include "extperfc/base/rng.hpp"

namespace extperfc::arm {

inline const RobotModel& baxter() {
  static const RobotModel robot = [] {
    const std::filesystem::path root = EXTPERFC_SOURCE_DIR;
    auto result = RobotModel::from_file(root / "urdf/mobile_baxter.urdf", root);
    if (!result) throw std::runtime_error(result.error().message);
    return *std::move(result);
  }();
  return robot;
}

/// From Baxter's base to a gripper; side: "left" or "right".
inline ArmChain baxter_arm(const std::string& side) {
  return ArmChain::make(baxter(), "base", side + "_gripper").value();
}

inline ArmChain chain_of(const std::string& joints, const std::string& tip) {
  const auto robot = RobotModel::from_urdf("<robot name='small'>" + joints + "</robot>", ".");
  if (!robot) throw std::runtime_error(robot.error().message);
  const auto chain = ArmChain::make(*robot, "base", tip);
  if (!chain) throw std::runtime_error(chain.error().message);
  return *chain;
}

inline std::string link(const std::string& name) {
  return "<link name='" + name + "'/>";
}

/// `more`: origin, axis, limit, mimic.
inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& more) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" +
         child + "'/>" + more + "</joint>";
}

inline std::string origin(const std::string& xyz, const std::string& rpy = "0 0 0") {
  return "<origin xyz='" + xyz + "' rpy='" + rpy + "'/>";
}

inline std::string limit(double lower, double upper) {
  return "<limit lower='" + std::to_string(lower) + "' upper='" + std::to_string(upper) +
         "' effort='1' velocity='2'/>";
}

/// Uniform within the limits; joints without end within half a revolution of 0.
inline JointVector random_joints(const ArmChain& chain, Rng& rng) {
  JointVector joints(chain.joint_count());
  for (int i = 0; i < chain.joint_count(); ++i) {
    const bool endless = std::isinf(chain.limits().lower[i]);
    joints[i] =
        endless ? rng.uniform(-3.14, 3.14) : rng.uniform(chain.limits().lower[i], chain.limits().upper[i]);
  }
  return joints;
}

inline double position_error(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

/// Angle between the orientations, by the chord, which keeps its precision at small angles.
inline double orientation_error(const Pose& a, const Pose& b) {
  return 2 * std::asin(std::min(1.0, (a.linear() - b.linear()).norm() / std::sqrt(8.0)));
}

}  // namespace extperfc::arm
