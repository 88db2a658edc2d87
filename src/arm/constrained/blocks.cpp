#include "arm/constrained/blocks.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "extperfc/base/math.hpp"

#include "arm/kinematics/rotation.hpp"

namespace extperfc::arm {

namespace {
/// Below this angle series replace quotients of small numbers [rad].
constexpr double kSmallRad = 1e-4;

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, kMaxJoints>;
using RotationRows = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints>;

void orientation_rows(const Eigen::Matrix3d& target_R_link, const RotationRows& rotation_rows_in_link,
                      Eigen::Ref<Eigen::VectorXd> residual, ConstraintJacobian* jacobian, int row) {
  const Eigen::Vector3d vector = rotation_vector(target_R_link);
  residual = vector;
  if (jacobian) jacobian->middleRows(row, 3) = vector_change(-vector) * rotation_rows_in_link;
}

// With s the axis across its target and c along it, F = (angle / |s|) s where tan(angle) = |s| / c, so that
// dF = (angle / |s|) ds + s (d angle |s| - angle d|s|) / |s|^2 with d angle = c d|s| - |s| dc.
void axis_rows(const Block& block, const Placed& link, Eigen::Ref<Eigen::VectorXd> residual,
               ConstraintJacobian* jacobian) {
  const Eigen::Vector3d axis = link.root_T_link.linear() * block.constraint.axis;
  const Eigen::Vector2d s = block.across.transpose() * axis;
  const double c = block.direction.dot(axis);
  const double length = s.norm();
  const double angle = std::atan2(length, c);
  const bool small = length < kSmallRad;
  if (small && c < 0) {
    residual << kPi, 0.0;
  } else {
    residual = (small ? 1.0 : angle / length) * s;
  }
  if (!jacobian) return;
  const RotationRows moves = -cross_matrix(axis) * link.jacobian.bottomRows<3>();  // of the axis per joint
  const Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxJoints> ds = block.across.transpose() * moves;
  auto rows = jacobian->middleRows(block.first_row, 2);
  if (small) {
    rows = ds;
    return;
  }
  const Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxJoints> dlength =
      s.transpose() * ds / length;
  const Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxJoints> dangle =
      c * dlength - length * (block.direction.transpose() * moves);
  rows = (angle / length) * ds + (s / (length * length)) * (length * dangle - angle * dlength);
}

void relative_rows(const Block& block, const Placed& link, const Placed& other,
                   Eigen::Ref<Eigen::VectorXd> residual, ConstraintJacobian* jacobian) {
  const Eigen::Matrix3d other_R_root = other.root_T_link.linear().transpose();
  const Pose& target = *block.constraint.target;
  const Eigen::Vector3d apart = link.root_T_link.translation() - other.root_T_link.translation();
  residual.head<3>() = other_R_root * apart - target.translation();
  const Eigen::Matrix3d link_R_root = link.root_T_link.linear().transpose();
  const Eigen::Matrix3d target_R_link =
      target.linear().transpose() * other_R_root * link.root_T_link.linear();
  RotationRows rotation_rows;
  if (jacobian) {
    rotation_rows = link_R_root * (link.jacobian.bottomRows<3>() - other.jacobian.bottomRows<3>());
    jacobian->middleRows(block.first_row, 3) =
        other_R_root * (link.jacobian.topRows<3>() - other.jacobian.topRows<3>() +
                        cross_matrix(apart) * other.jacobian.bottomRows<3>());
  }
  orientation_rows(target_R_link, rotation_rows, residual.tail<3>(), jacobian, block.first_row + 3);
}

void position_rows(const Block& block, const Placed& link, Eigen::Ref<Eigen::VectorXd> residual,
                   ConstraintJacobian* jacobian) {
  const Eigen::Vector3d away = link.root_T_link.translation() - block.constraint.target->translation();
  if (block.constraint.kind == ToolConstraintKind::kKeepPlane) {
    residual[0] = block.direction.dot(away);
    if (jacobian) jacobian->row(block.first_row) = block.direction.transpose() * link.jacobian.topRows<3>();
    return;
  }
  residual = block.across.transpose() * away;
  if (jacobian)
    jacobian->middleRows(block.first_row, 2) = block.across.transpose() * link.jacobian.topRows<3>();
}

}  // namespace

JointVector Tool::chain_joints(const JointVector& group) const {
  JointVector result = standing;
  for (std::size_t j = 0; j < group_joint.size(); ++j)
    if (group_joint[j] >= 0) result[static_cast<Eigen::Index>(j)] = group[group_joint[j]];
  return result;
}

Rates rates_of(const Tool& tool, const JointVector& displacement) {
  Rates rates;
  for (std::size_t j = 0; j < tool.group_joint.size(); ++j)
    if (tool.group_joint[j] >= 0)
      (tool.prismatic[j] ? rates.sliding : rates.rotating) += std::abs(displacement[tool.group_joint[j]]);
  return rates;
}

Offset offset_of(const Block& block, const Pose& root_T_link, const Pose& root_T_other) {
  Offset offset;
  const Pose& target = *block.constraint.target;
  const auto orientation = [&offset](const Eigen::Matrix3d& target_R_link) {
    const Eigen::Matrix3d away = (target_R_link - Eigen::Matrix3d::Identity()) / std::sqrt(2.0);
    offset.direction = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(away.data());
  };
  switch (block.constraint.kind) {
    case ToolConstraintKind::kKeepAxis:
      offset.direction.head<3>() = root_T_link.linear() * block.constraint.axis - block.direction;
      break;
    case ToolConstraintKind::kKeepPlane:
      offset.position.x() = block.direction.dot(root_T_link.translation() - target.translation());
      break;
    case ToolConstraintKind::kKeepLine:
      offset.position.head<2>() =
          block.across.transpose() * (root_T_link.translation() - target.translation());
      break;
    case ToolConstraintKind::kKeepOrientation:
      orientation(target.linear().transpose() * root_T_link.linear());
      break;
    case ToolConstraintKind::kKeepRelative: {
      const Pose other_T_link = root_T_other.inverse() * root_T_link;
      offset.position = other_T_link.translation() - target.translation();
      orientation(target.linear().transpose() * other_T_link.linear());
      break;
    }
  }
  return offset;
}

double angle_of(double offset) {
  return 2.0 * std::asin(std::min(1.0, 0.5 * offset));
}

// A Ref is copied on purpose: the rows are written through it.
// NOLINTBEGIN(performance-unnecessary-value-param)
void evaluate(const Block& block, const Placed& link, const Placed& other,
              Eigen::Ref<Eigen::VectorXd> residual, ConstraintJacobian* jacobian) {
  switch (block.constraint.kind) {
    case ToolConstraintKind::kKeepAxis:
      return axis_rows(block, link, residual, jacobian);
    case ToolConstraintKind::kKeepPlane:
    case ToolConstraintKind::kKeepLine:
      return position_rows(block, link, residual, jacobian);
    case ToolConstraintKind::kKeepOrientation: {
      RotationRows rotation_rows;
      if (jacobian) rotation_rows = link.root_T_link.linear().transpose() * link.jacobian.bottomRows<3>();
      return orientation_rows(block.constraint.target->linear().transpose() * link.root_T_link.linear(),
                              rotation_rows, residual, jacobian, block.first_row);
    }
    case ToolConstraintKind::kKeepRelative:
      return relative_rows(block, link, other, residual, jacobian);
  }
}
// NOLINTEND(performance-unnecessary-value-param)

}  // namespace extperfc::arm
