#include "extperfc/arm/path_constraint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "arm/constrained/blocks.hpp"
#include "arm/kinematics/geometry.hpp"

namespace extperfc::arm {

namespace {

/// max |t (t - 1/2) (t - 1)| / 3! over [0, 1].
constexpr double kCubicRemainder = 0.00801875373874480;

Pose pose_of(const Tool& tool, const JointVector& joints) {
  return tool.chain.forward(tool.chain_joints(joints));
}

Offset offset_at(const Blocks& blocks, const Block& block, const JointVector& joints) {
  const Pose link = pose_of(blocks.tools[block.tool], joints);
  if (block.other_tool < 0) return offset_of(block, link, block.root_T_other);
  return offset_of(block, link, pose_of(blocks.tools[block.other_tool], joints));
}

double error_of(const Offset& offset) {
  return std::max(offset.position.norm(), angle_of(offset.direction.norm()));
}

/// Pose and Jacobian from one pass along the chain.
Placed placed_at(const Blocks& blocks, const Tool& tool, const JointVector& joints) {
  const JointVector own = tool.chain_joints(joints);
  return with_size(tool.chain.joint_count(), [&](auto size) {
    const ChainGeometry& geometry = tool.chain.geometry();
    Placement<size()> at;
    place<size()>(geometry, geometry.links[0], Joints<size()>(own), at);
    Columns<size()> columns;
    chain_jacobian<size()>(geometry, at, columns);
    Placed placed;
    placed.root_T_link.linear() = at.rotation;
    placed.root_T_link.translation() = at.position;
    placed.jacobian.setZero(6, blocks.joints);
    for (std::size_t j = 0; j < tool.group_joint.size(); ++j)
      if (tool.group_joint[j] >= 0)
        placed.jacobian.col(tool.group_joint[j]) = columns.col(static_cast<int>(j));
    return placed;
  });
}

/// Rates and reach of a block: both tools of a relative pose count.
struct Motion {
  double rotating{0}, sliding{0}, reach_m{0};
};

Motion motion_of(const Blocks& blocks, const Block& block, const JointVector& displacement) {
  Motion motion;
  for (const int tool : {block.tool, block.other_tool}) {
    if (tool < 0) continue;
    const auto rates = rates_of(blocks.tools[tool], displacement);
    motion.rotating += rates.rotating;
    motion.sliding += rates.sliding;
    motion.reach_m += blocks.tools[tool].reach_m;
  }
  if (block.constraint.kind == ToolConstraintKind::kKeepRelative && block.other_tool < 0)
    motion.reach_m += block.root_T_other.translation().norm();
  return motion;
}

/// Bounds of both parts of the offset on a segment: what a quadratic has, and the rest.
double bound_of(const Blocks& blocks, const Block& block, const JointVector& displacement, double position,
                double direction) {
  const Motion motion = motion_of(blocks, block, displacement);
  const double rotations = motion.rotating * motion.rotating * motion.rotating;
  const double slides = 3.0 * motion.rotating * motion.rotating * motion.sliding;
  const auto kind = block.constraint.kind;
  const bool places = kind == ToolConstraintKind::kKeepPlane || kind == ToolConstraintKind::kKeepLine;
  double bound = 0;
  if (places || kind == ToolConstraintKind::kKeepRelative)
    bound = position + kCubicRemainder * (rotations * motion.reach_m + slides);
  if (!places) bound = std::max(bound, angle_of(direction + kCubicRemainder * rotations));
  return bound;
}

double segment_bound(const Blocks& blocks, const Block& block, const JointVector& from,
                     const JointVector& to) {
  const Offset a = offset_at(blocks, block, from);
  const Offset b = offset_at(blocks, block, to);
  const Offset m = offset_at(blocks, block, 0.5 * (from + to));
  const auto longest = [](const auto& first, const auto& last, const auto& middle) {
    return std::max(first.norm(), last.norm()) + (middle - 0.5 * (first + last)).norm();
  };
  return bound_of(blocks, block, to - from, longest(a.position, b.position, m.position),
                  longest(a.direction, b.direction, m.direction));
}

/// Keeps redundant equations (a closed chain whose hands also keep level) from making the system singular.
constexpr double kMinDamping = 1e-12;
/// Damping per square of the residual: the step stays Newton's near the solution.
constexpr double kDamping = 1e-2;
constexpr double kMaxStepRad = 0.5;

using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxEquations, kMaxEquations>;

/// J^T (J J^T + damping)^-1 r over the columns that are not held.
JointVector pull_back(const ConstraintJacobian& jacobian, const ConstraintResidual& residual,
                      double damping) {
  Square square = jacobian * jacobian.transpose();
  square.diagonal().array() += damping;
  return jacobian.transpose() * square.ldlt().solve(residual);
}

/// Joints at a limit that `step` would leave; their columns become zero. True when there are new ones.
bool hold(const JointVector& joints, const JointVector& step, const JointLimits& limits,
          ConstraintJacobian* jacobian, JointVector* free) {
  bool any = false;
  for (Eigen::Index j = 0; j < joints.size(); ++j) {
    const bool outward =
        (step[j] > 0 && joints[j] >= limits.upper[j]) || (step[j] < 0 && joints[j] <= limits.lower[j]);
    if (!outward || (*free)[j] == 0.0) continue;
    jacobian->col(j).setZero();
    (*free)[j] = 0.0;
    any = true;
  }
  return any;
}

}  // namespace

Result<PathConstraint> PathConstraint::make(const RobotModel& robot, const PathConstraintParams& params) {
  auto blocks = make_blocks(robot, params);
  if (!blocks) return tl::unexpected(blocks.error());
  return PathConstraint(std::make_shared<const Blocks>(*std::move(blocks)));
}

int PathConstraint::joint_count() const {
  return blocks_->joints;
}

int PathConstraint::equation_count() const {
  return blocks_->equations;
}

const std::vector<ToolConstraint>& PathConstraint::constraints() const {
  return blocks_->constraints;
}

void PathConstraint::check_size(const JointVector& joints) const {
  if (joints.size() != blocks_->joints)
    throw std::invalid_argument("the constraint is on " + std::to_string(blocks_->joints) + " joints, not " +
                                std::to_string(joints.size()));
}

ConstraintResidual PathConstraint::residual(const JointVector& joints) const {
  ConstraintResidual result;
  (void)jacobian(joints, &result);
  return result;
}

ConstraintJacobian PathConstraint::jacobian(const JointVector& joints, ConstraintResidual* residual) const {
  check_size(joints);
  ConstraintJacobian result = ConstraintJacobian::Zero(blocks_->equations, blocks_->joints);
  ConstraintResidual all(blocks_->equations);
  for (const Block& block : blocks_->blocks) {
    const Placed link = placed_at(*blocks_, blocks_->tools[block.tool], joints);
    const bool relative = block.constraint.kind == ToolConstraintKind::kKeepRelative;
    const Placed other = !relative ? Placed{}
                         : block.other_tool < 0
                             ? Placed{block.root_T_other, Jacobian::Zero(6, blocks_->joints)}
                             : placed_at(*blocks_, blocks_->tools[block.other_tool], joints);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> part(block.rows);
    evaluate(block, link, other, part, &result);
    all.segment(block.first_row, block.rows) = part;
  }
  if (residual) *residual = all;
  return result;
}

double PathConstraint::error(const JointVector& joints) const {
  check_size(joints);
  if (!joints.allFinite()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (const Block& block : blocks_->blocks)
    worst = std::max(worst, error_of(offset_at(*blocks_, block, joints)));
  return worst;
}

double PathConstraint::error(const JointVector& joints, int constraint) const {
  check_size(joints);
  if (!joints.allFinite()) return std::numeric_limits<double>::infinity();
  return error_of(offset_at(*blocks_, blocks_->blocks.at(static_cast<std::size_t>(constraint)), joints));
}

double PathConstraint::segment_error(const JointVector& from, const JointVector& to) const {
  check_size(from);
  check_size(to);
  if (!from.allFinite() || !to.allFinite()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (const Block& block : blocks_->blocks)
    worst = std::max(worst, segment_bound(*blocks_, block, from, to));
  return worst;
}

double PathConstraint::segment_error(const JointVector& from, const JointVector& to, double ends) const {
  check_size(from);
  check_size(to);
  if (!from.allFinite() || !to.allFinite()) return std::numeric_limits<double>::infinity();
  double worst = 0;
  for (const Block& block : blocks_->blocks) {
    const Offset middle = offset_at(*blocks_, block, 0.5 * (from + to));
    worst = std::max(worst, bound_of(*blocks_, block, to - from, 2.0 * ends + middle.position.norm(),
                                     2.0 * ends + middle.direction.norm()));
  }
  return worst;
}

// Within r of q each column changes by at most the sum of |displacements| <= sqrt(n) r, times the reach for
// positions, so that the Frobenius norm over n columns changes by at most n r of those. The rotation part of
// an orientation counts directions twice at most (three columns of a matrix, divided by sqrt(2)).
double PathConstraint::steepness(const JointVector& joints, double radius_rad) const {
  const ConstraintJacobian slopes = jacobian(joints);
  double worst = 0;
  for (const Block& block : blocks_->blocks) {
    const double reach = motion_of(*blocks_, block, JointVector::Zero(joints.size())).reach_m;
    const double change = 2.0 * static_cast<double>(joints.size()) * radius_rad * std::max(1.0, reach);
    worst = std::max(worst, slopes.middleRows(block.first_row, block.rows).norm() + change);
  }
  return worst;
}

std::optional<JointVector> PathConstraint::project(const JointVector& joints, const JointLimits& limits,
                                                   const ProjectionParams& params) const {
  check_size(joints);
  if (!joints.allFinite()) return std::nullopt;
  JointVector at = joints.cwiseMax(limits.lower).cwiseMin(limits.upper);
  for (int i = 0; i < params.max_iterations; ++i) {
    ConstraintResidual residual;
    ConstraintJacobian slopes = jacobian(at, &residual);
    if (residual.norm() <= params.tolerance) return at;
    const double damping = kMinDamping + kDamping * residual.squaredNorm();
    JointVector free = JointVector::Ones(at.size());
    JointVector step = -pull_back(slopes, residual, damping);
    while (hold(at, step, limits, &slopes, &free)) step = -pull_back(slopes, residual, damping);
    const double length = step.norm();
    if (length > kMaxStepRad) step *= kMaxStepRad / length;
    at = (at + step).cwiseMax(limits.lower).cwiseMin(limits.upper);
  }
  if (residual(at).norm() <= params.tolerance) return at;
  return std::nullopt;
}

JointVector PathConstraint::tangent(const JointVector& joints, const JointVector& direction,
                                    const JointLimits& limits) const {
  check_size(joints);
  check_size(direction);
  ConstraintJacobian slopes = jacobian(joints);
  JointVector free = JointVector::Ones(joints.size());
  JointVector along = direction;
  do {
    const JointVector wanted = direction.cwiseProduct(free);
    along = wanted - pull_back(slopes, slopes * wanted, kMinDamping);
  } while (hold(joints, along, limits, &slopes, &free));
  return along;
}

}  // namespace extperfc::arm
