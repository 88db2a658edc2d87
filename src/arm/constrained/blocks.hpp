#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "extperfc/arm/kinematics.hpp"
#include "extperfc/arm/path_constraint.hpp"

namespace extperfc::arm {

/// A link that joints of the group carry, from the robot's root.
struct Tool {
  ArmChain chain;
  std::vector<int> group_joint;  ///< per joint of the chain: index in the group, -1 for one that stands
  JointVector standing;          ///< values of the joints that stand
  std::vector<bool> prismatic;   ///< per joint of the chain
  double reach_m{0};             ///< largest distance of the tip from the root link's origin or any joint

  [[nodiscard]] JointVector chain_joints(const JointVector& group) const;
};

/// Sums of absolute values of a displacement of the group, over the joints that carry a tool.
struct Rates {
  double rotating{0};  ///< of revolute joints [rad]
  double sliding{0};   ///< of prismatic joints [m]
};
[[nodiscard]] Rates rates_of(const Tool& tool, const JointVector& displacement);

/// Where a tool is, and its Jacobian by the group's joints (6 x joints of the group).
struct Placed {
  Pose root_T_link{Pose::Identity()};
  Jacobian jacobian;
};

/// One tool constraint with what is needed to evaluate it.
struct Block {
  ToolConstraint constraint;  ///< axis of unit length, target present
  int tool{0};
  int other_tool{-1};                   ///< kKeepRelative: -1 also for a link that no joint moves
  Pose root_T_other{Pose::Identity()};  ///< kKeepRelative with a link that no joint moves
  Eigen::Vector3d direction{
      Eigen::Vector3d::UnitZ()};       ///< in the root's frame: target of the axis, normal, line
  Eigen::Matrix<double, 3, 2> across;  ///< two directions across it
  int first_row{0};
  int rows{0};
};

struct Blocks {
  int joints{0};
  int equations{0};
  std::vector<Tool> tools;
  std::vector<Block> blocks;
  std::vector<ToolConstraint> constraints;
};

/// Errors: those of PathConstraint::make().
[[nodiscard]] Result<Blocks> make_blocks(const RobotModel& robot, const PathConstraintParams& params);

/// The vector whose length gives the error: its first part of positions [m], its second of directions (unit).
/// Zero where a constraint has no such part. Directions: a - target for an axis, the rotation matrix less the
/// identity, divided by sqrt(2), for orientations; both have the length 2 sin(angle / 2).
struct Offset {
  Eigen::Vector3d position{Eigen::Vector3d::Zero()};
  Eigen::Matrix<double, 9, 1> direction{Eigen::Matrix<double, 9, 1>::Zero()};
};
[[nodiscard]] Offset offset_of(const Block& block, const Pose& root_T_link, const Pose& root_T_other);

/// Angle of a direction's offset of that length [rad]; pi from 2 on.
[[nodiscard]] double angle_of(double offset);

/// Residual, and Jacobian when `jacobian` is not null, into the rows of the block.
void evaluate(const Block& block, const Placed& link, const Placed& other,
              Eigen::Ref<Eigen::VectorXd> residual, ConstraintJacobian* jacobian);

}  // namespace extperfc::arm
