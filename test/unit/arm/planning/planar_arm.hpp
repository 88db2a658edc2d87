#pragma once

#include <string>

#include "extperfc/arm/collision_checker.hpp"
#include "extperfc/arm/collision_model.hpp"
#include "extperfc/arm/collision_world.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

// Three links of 0.5 m in the plane z = 0, each a bar of 0.4 x 0.04 x 0.04 m that leaves 5 cm free at both
// joints; all joints turn about z within +-2.8 rad. Stretched out along x at zero:
//
//   base o==== j1 ====o==== j2 ====o==== j3 ====   tip at (1.5, 0)
inline std::string planar_arm_urdf() {
  std::string text = R"(<robot name="planar"><link name="base"/>)";
  for (int i = 1; i <= 3; ++i) {
    const auto n = std::to_string(i);
    text +=
        "<link name=\"bar" + n +
        R"("><collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision></link>)";
    text += "<joint name=\"j" + n + "\" type=\"revolute\"><parent link=\"" +
            (i == 1 ? "base" : "bar" + std::to_string(i - 1)) + "\"/><child link=\"bar" + n +
            "\"/><origin xyz=\"" + (i == 1 ? "0" : "0.5") +
            R"( 0 0"/><axis xyz="0 0 1"/><limit lower="-2.8" upper="2.8" velocity="1" effort="1"/></joint>)";
  }
  return text + "</robot>";
}

inline CollisionModel planar_arm() {
  const auto robot = RobotModel::from_urdf(planar_arm_urdf(), ".");
  CollisionModelParams params;
  params.joints = {"j1", "j2", "j3"};
  return CollisionModel::make(robot.value(), params).value();
}

/// A post of 0.1 m x 0.1 m at (x, y).
inline WorldObject post(const std::string& name, double x, double y, double side = 0.1) {
  WorldObject object;
  object.name = name;
  object.shapes.push_back({Box{{side, side, 0.5}}, Pose::Identity(), {}});
  object.root_T_object = make_pose({x, y, 0});
  return object;
}

inline JointVector joints(double a, double b, double c) {
  JointVector result(3);
  result << a, b, c;
  return result;
}

/// Whether Bullet finds every state of the polyline free, one every 0.002 rad.
inline bool free_all_along(CollisionChecker& checker, const std::vector<JointVector>& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const JointVector delta = path[i] - path[i - 1];
    const int steps = 1 + static_cast<int>(delta.norm() / 0.002);
    for (int s = 0; s <= steps; ++s)
      if (checker.contact(path[i - 1] + delta * (static_cast<double>(s) / steps))) return false;
  }
  return true;
}

}  // namespace extperfc::arm
