#pragma once

#include <vector>

#include "extperfc/world/robot_model.hpp"

#include "simulate/bodies/mass_properties.hpp"

namespace extperfc::simulate {

/// Links of a robot that never move against each other.
struct RigidGroup {
  int joint{-1};                          ///< joint that moves the group; -1: it hangs on the root
  int parent{-1};                         ///< group; -1 for the root's
  int link{0};                            ///< link whose frame is the group's frame
  Pose parent_T_joint{Pose::Identity()};  ///< from the parent group's frame, at position 0
  MassProperties mass;                    ///< in the group's frame
  std::vector<Shape> collisions;          ///< poses in the group's frame
};

/// A robot as rigid groups: links behind fixed joints are merged into their parent. Wheels (continuous
/// joints) belong to the group that carries them: they look the same at every angle.
struct RigidTree {
  std::vector<RigidGroup> groups;  ///< the root's first, a parent before its children
  std::vector<int> group_of_link;
  std::vector<int> group_of_joint;  ///< group that a joint moves; -1 when it moves none
};
[[nodiscard]] RigidTree make_rigid_tree(const RobotModel& robot);

/// Two fingers on prismatic joints of which one mimics the other, on a hand that moves.
struct GripperFingers {
  int joint{-1};         ///< of the finger that is driven
  int mimic_joint{-1};   ///< of the other one
  int hand{-1};          ///< group that carries both
  int finger{-1};        ///< group
  int mimic_finger{-1};  ///< group
  double closing{-1};    ///< direction in which the driven joint closes, +1 or -1
};
[[nodiscard]] std::vector<GripperFingers> find_grippers(const RobotModel& robot, const RigidTree& tree);

/// A mimic joint's value for all joints' `positions`; the joint's own otherwise.
[[nodiscard]] double followed_position(const RobotModel& robot, int joint,
                                       const std::vector<double>& positions);

/// Efforts that hold the robot against gravity, one per joint [N m] or [N]; 0 for fixed joints and wheels.
/// From the masses behind each joint and the column of the Jacobian at their centre. O(links).
[[nodiscard]] std::vector<double> gravity_efforts(const RobotModel& robot, const RigidTree& tree,
                                                  const std::vector<Pose>& world_T_link, double gravity_m_s2);

}  // namespace extperfc::simulate
