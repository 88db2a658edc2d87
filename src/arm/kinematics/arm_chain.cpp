#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "extperfc/arm/kinematics.hpp"
#include "extperfc/world/frame_about.hpp"

#include "arm/kinematics/geometry.hpp"
#include "arm/kinematics/kdl_chain.hpp"
#include "arm/kinematics/reach.hpp"

namespace extperfc::arm {
namespace {

tl::unexpected<Error> does_not_carry(const std::string& root, const std::string& tip) {
  return fail(ErrorCode::kInvalidArgument, "link '" + root + "' does not carry '" + tip + "'");
}

/// Indices of the joints from the root to the tip.
Result<std::vector<int>> path(const RobotModel& robot, const std::string& root, const std::string& tip) {
  for (const std::string& name : {root, tip})
    if (!robot.link(name)) return fail(ErrorCode::kNotFound, "the robot has no link '" + name + "'");
  std::vector<int> joints;
  for (int link = *robot.link(tip); link != *robot.link(root);) {
    const int joint = robot.links()[link].parent_joint;
    if (joint < 0) return does_not_carry(root, tip);
    joints.push_back(joint);
    link = robot.joints()[joint].parent_link;
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

std::optional<Error> refuse(const Joint& joint) {
  const std::string name = "joint '" + joint.name + "' ";
  if (joint.mimic)
    return Error{ErrorCode::kUnsupported, name + "follows another joint; a chain needs joints of its own"};
  if (joint.type == JointType::kContinuous) return std::nullopt;
  if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper) || !(joint.lower < joint.upper))
    return Error{ErrorCode::kInvalidArgument,
                 name + "has no range: its limits must be finite, lower < upper"};
  return std::nullopt;
}

Result<std::vector<int>> moving_joints(const RobotModel& robot, const std::vector<int>& joints) {
  std::vector<int> moving;
  for (const int index : joints) {
    const Joint& joint = robot.joints()[index];
    if (joint.type == JointType::kFixed) continue;
    if (const auto error = refuse(joint)) return tl::unexpected(*error);
    moving.push_back(index);
  }
  if (moving.empty()) return fail(ErrorCode::kInvalidArgument, "no moving joint between the two links");
  if (moving.size() > kMaxJoints)
    return fail(ErrorCode::kUnsupported, std::to_string(moving.size()) + " joints in one chain; " +
                                             std::to_string(kMaxJoints) + " at most");
  return moving;
}

ChainLink to_link(const Pose& pose) {
  return {pose.linear(), pose.translation()};
}

std::shared_ptr<const ChainGeometry> to_geometry(const RobotModel& robot, const std::vector<int>& joints,
                                                 const JointLimits& limits) {
  auto geometry = std::make_shared<ChainGeometry>();
  ChainLink before;
  for (const int index : joints) {
    const Joint& joint = robot.joints()[index];
    before = before * to_link(joint.parent_T_joint);
    if (joint.type == JointType::kFixed) continue;
    const ChainLink rotation{frame_about(joint.axis)};
    geometry->links[geometry->count] = before * rotation;
    geometry->prismatic[geometry->count] = joint.type == JointType::kPrismatic;
    ++geometry->count;
    before = ChainLink{rotation.rotation.transpose(), Eigen::Vector3d::Zero()};
  }
  geometry->links[geometry->count] = before;
  geometry->reach = find_reach(*geometry, limits);
  return geometry;
}

template <int N>
Placement<N> placed(const ChainGeometry& geometry, const JointVector& joints) {
  Placement<N> at;
  place<N>(geometry, geometry.links[0], Joints<N>(joints), at);
  return at;
}

void check_size(const ArmChain& chain, const JointVector& joints) {
  if (joints.size() != chain.joint_count())
    throw std::invalid_argument("the chain to '" + chain.tip_link() + "' has " +
                                std::to_string(chain.joint_count()) + " joints, not " +
                                std::to_string(joints.size()));
}

}  // namespace

Result<ArmChain> ArmChain::make(const RobotModel& robot, const std::string& root_link,
                                const std::string& tip_link) {
  const auto joints = path(robot, root_link, tip_link);
  if (!joints) return tl::unexpected(joints.error());
  auto moving = moving_joints(robot, *joints);
  if (!moving) return tl::unexpected(moving.error());
  ArmChain chain;
  chain.root_link_ = root_link;
  chain.tip_link_ = tip_link;
  const auto count = static_cast<Eigen::Index>(moving->size());
  chain.limits_ = {JointVector(count), JointVector(count)};
  chain.max_velocity_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Joint& joint = robot.joints()[(*moving)[i]];
    const bool endless = joint.type == JointType::kContinuous;
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    chain.joint_names_.push_back(joint.name);
    chain.limits_.lower[i] = endless ? -kEndless : joint.lower;
    chain.limits_.upper[i] = endless ? kEndless : joint.upper;
    chain.max_velocity_[i] = joint.max_velocity;
  }
  chain.robot_joints_ = *std::move(moving);
  chain.kdl_ = std::make_shared<const KDL::Chain>(kdl_chain(robot, *joints));
  chain.geometry_ = to_geometry(robot, *joints, chain.limits_);
  return chain;
}

JointVector ArmChain::mid_range() const {
  JointVector middle = JointVector::Zero(joint_count());
  for (int i = 0; i < joint_count(); ++i)
    if (std::isfinite(limits_.lower[i])) middle[i] = 0.5 * (limits_.lower[i] + limits_.upper[i]);
  return middle;
}

JointVector ArmChain::clamp(const JointVector& joints) const {
  check_size(*this, joints);
  return joints.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
}

JointVector ArmChain::difference(const JointVector& to, const JointVector& from) const {
  check_size(*this, to);
  check_size(*this, from);
  JointVector delta = to - from;
  for (int i = 0; i < joint_count(); ++i)
    if (std::isinf(limits_.lower[i])) delta[i] = std::remainder(delta[i], kRevolution);
  return delta;
}

bool ArmChain::within_limits(const JointVector& joints) const {
  check_size(*this, joints);
  return (joints.array() >= limits_.lower.array()).all() && (joints.array() <= limits_.upper.array()).all();
}

Pose ArmChain::forward(const JointVector& joints) const {
  check_size(*this, joints);
  return with_size(joint_count(), [&](auto size) {
    const auto at = placed<size()>(*geometry_, joints);
    Pose pose = Pose::Identity();
    pose.linear() = at.rotation;
    pose.translation() = at.position;
    return pose;
  });
}

Jacobian ArmChain::jacobian(const JointVector& joints) const {
  check_size(*this, joints);
  return with_size(joint_count(), [&](auto size) {
    Columns<size()> columns;
    chain_jacobian<size()>(*geometry_, placed<size()>(*geometry_, joints), columns);
    return Jacobian(columns);
  });
}

}  // namespace extperfc::arm
