#include "arm/kinematics/kdl_chain.hpp"

#include <stdexcept>

#include "extperfc/arm/kinematics.hpp"

namespace extperfc::arm {
namespace {

KDL::Joint to_joint(const Joint& joint) {
  if (joint.type == JointType::kFixed) return KDL::Joint(joint.name, KDL::Joint::None);
  const KDL::Frame frame = to_kdl(joint.parent_T_joint);
  const KDL::Vector axis = frame.M * KDL::Vector(joint.axis.x(), joint.axis.y(), joint.axis.z());
  const auto type = joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
  return KDL::Joint(joint.name, frame.p, axis, type);
}

}  // namespace

KDL::Chain kdl_chain(const RobotModel& robot, const std::vector<int>& joints) {
  KDL::Chain chain;
  for (const int index : joints) {
    const Joint& joint = robot.joints()[index];
    const std::string& child = robot.links()[joint.child_link].name;
    chain.addSegment(KDL::Segment(child, to_joint(joint), to_kdl(joint.parent_T_joint)));
  }
  return chain;
}

KDL::Frame to_kdl(const Pose& pose) {
  KDL::Frame frame;
  for (int row = 0; row < 3; ++row) {
    frame.p(row) = pose.translation()[row];
    for (int column = 0; column < 3; ++column) frame.M(row, column) = pose.linear()(row, column);
  }
  return frame;
}

Pose from_kdl(const KDL::Frame& frame) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    pose.translation()[row] = frame.p(row);
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = frame.M(row, column);
  }
  return pose;
}

KDL::JntArray to_kdl(const JointVector& joints) {
  KDL::JntArray out(static_cast<unsigned>(joints.size()));
  out.data = joints;
  return out;
}

JointVector from_kdl(const KDL::JntArray& joints) {
  if (joints.rows() > kMaxJoints) throw std::invalid_argument("more joints than a chain may have");
  return joints.data;
}

}  // namespace extperfc::arm
