#include "simulate/bodies/rigid_tree.hpp"

#include <cstddef>

namespace extperfc::simulate {
namespace {

bool starts_group(const Joint& joint) {
  return joint.type == JointType::kRevolute || joint.type == JointType::kPrismatic;
}

void add_link(const Link& link, const Pose& group_T_link, RigidGroup& group) {
  if (link.inertial)
    group.mass = combined(group.mass, transformed(group_T_link, mass_properties(*link.inertial)));
  for (Shape shape : link.collisions) {
    shape.body_T_shape = group_T_link * shape.body_T_shape;
    group.collisions.push_back(std::move(shape));
  }
}

/// Middle of a group's collision shapes, in the frame of its parent group, at joint position 0.
Eigen::Vector3d middle(const RigidGroup& group) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Shape& shape : group.collisions) sum += shape.body_T_shape.translation();
  if (!group.collisions.empty()) sum /= static_cast<double>(group.collisions.size());
  return group.parent_T_joint * sum;
}

}  // namespace

RigidTree make_rigid_tree(const RobotModel& robot) {
  RigidTree tree;
  tree.group_of_link.assign(robot.links().size(), -1);
  tree.group_of_joint.assign(robot.joints().size(), -1);
  std::vector<Pose> group_T_link(robot.links().size(), Pose::Identity());
  for (std::size_t i = 0; i < robot.links().size(); ++i) {
    const Link& link = robot.links()[i];
    const Joint* const joint = link.parent_joint < 0 ? nullptr : &robot.joints()[link.parent_joint];
    if (joint == nullptr || starts_group(*joint)) {
      RigidGroup group;
      group.link = static_cast<int>(i);
      if (joint != nullptr) {
        group.joint = link.parent_joint;
        group.parent = tree.group_of_link[joint->parent_link];
        group.parent_T_joint = group_T_link[joint->parent_link] * joint->parent_T_joint;
        tree.group_of_joint[link.parent_joint] = static_cast<int>(tree.groups.size());
      }
      tree.group_of_link[i] = static_cast<int>(tree.groups.size());
      tree.groups.push_back(std::move(group));
    } else {
      tree.group_of_link[i] = tree.group_of_link[joint->parent_link];
      group_T_link[i] = group_T_link[joint->parent_link] * joint->parent_T_joint;
    }
    add_link(link, group_T_link[i], tree.groups[tree.group_of_link[i]]);
  }
  return tree;
}

std::vector<GripperFingers> find_grippers(const RobotModel& robot, const RigidTree& tree) {
  std::vector<GripperFingers> grippers;
  for (std::size_t i = 0; i < robot.joints().size(); ++i) {
    const Joint& joint = robot.joints()[i];
    if (joint.type != JointType::kPrismatic || !joint.mimic) continue;
    const Joint& driver = robot.joints()[joint.mimic->joint];
    if (driver.type != JointType::kPrismatic) continue;
    GripperFingers gripper;
    gripper.joint = joint.mimic->joint;
    gripper.mimic_joint = static_cast<int>(i);
    gripper.finger = tree.group_of_joint[gripper.joint];
    gripper.mimic_finger = tree.group_of_joint[gripper.mimic_joint];
    const RigidGroup& finger = tree.groups[gripper.finger];
    gripper.hand = finger.parent;
    if (gripper.hand <= 0) continue;  // a gripper on the root has no hand that moves
    const Eigen::Vector3d towards_other = middle(tree.groups[gripper.mimic_finger]) - middle(finger);
    gripper.closing = towards_other.dot(finger.parent_T_joint.linear() * driver.axis) >= 0 ? 1 : -1;
    grippers.push_back(gripper);
  }
  return grippers;
}

double followed_position(const RobotModel& robot, int joint, const std::vector<double>& positions) {
  const auto& mimic = robot.joints()[joint].mimic;
  return mimic ? mimic->multiplier * positions[mimic->joint] + mimic->offset : positions[joint];
}

std::vector<double> gravity_efforts(const RobotModel& robot, const RigidTree& tree,
                                    const std::vector<Pose>& world_T_link, double gravity_m_s2) {
  // Mass and first moment of everything behind each group, from the leaves to the root.
  std::vector<double> mass(tree.groups.size());
  std::vector<Eigen::Vector3d> moment(tree.groups.size());
  for (std::size_t i = 0; i < tree.groups.size(); ++i) {
    const RigidGroup& group = tree.groups[i];
    mass[i] = group.mass.mass_kg;
    moment[i] = mass[i] * (world_T_link[group.link] * group.mass.com);
  }
  std::vector<double> efforts(robot.joints().size(), 0.0);
  for (std::size_t i = tree.groups.size() - 1; i > 0; --i) {
    const RigidGroup& group = tree.groups[i];
    mass[group.parent] += mass[i];
    moment[group.parent] += moment[i];
    const Joint& joint = robot.joints()[group.joint];
    const Pose& world_T_joint = world_T_link[group.link];
    const Eigen::Vector3d axis = world_T_joint.linear() * joint.axis;
    const Eigen::Vector3d lift(0, 0, gravity_m_s2);
    efforts[group.joint] = joint.type == JointType::kPrismatic
                               ? axis.dot(mass[i] * lift)
                               : axis.dot((moment[i] - mass[i] * world_T_joint.translation()).cross(lift));
  }
  return efforts;
}

}  // namespace extperfc::simulate
