#include "simulate/control/robot_joints.hpp"

#include <map>

namespace extperfc::simulate {
namespace {

constexpr std::array<const char*, 4> kWheelNames{"wheel_front_left_joint", "wheel_front_right_joint",
                                                 "wheel_rear_left_joint", "wheel_rear_right_joint"};

/// Looks names up and remembers the first that is missing.
class Finder {
 public:
  explicit Finder(const RobotModel& robot) : robot_(robot) {}

  int joint(const std::string& name) { return found("joint", name, robot_.joint(name)); }
  int link(const std::string& name) { return found("link", name, robot_.link(name)); }
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  int found(const char* kind, const std::string& name, std::optional<int> index) {
    if (!index && missing_.empty()) missing_ = std::string(kind) + " '" + name + "'";
    return index.value_or(-1);
  }

  const RobotModel& robot_;
  std::string missing_;
};

/// Arm poses of the left arm; the right one's is its mirror image in s0, e0, w0 and w2 (neutral has none of
/// these).
const std::map<std::string, ArmValues>& left_poses() {
  static const std::map<std::string, ArmValues> kPoses{
      {"untuck", {-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5}},
      {"tuck", {-1.0, -2.07, 3.0, 2.55, 0.0, 0.01, 0.0}},
      {"neutral", {0, -0.55, 0, 0.75, 0, 1.26, 0}}};
  return kPoses;
}

ArmValues mirrored(ArmValues values) {
  for (const int joint : {0, 2, 4, 6}) values[joint] = -values[joint];
  return values;
}

}  // namespace

Result<RobotJoints> find_joints(const RobotModel& robot) {
  Finder finder(robot);
  RobotJoints found;
  for (const Side side : kSides) {
    const std::string name = to_string(side);
    auto& arm = found.arms[static_cast<int>(side)];
    for (int i = 0; i < kArmJoints; ++i) arm.joints[i] = finder.joint(name + "_" + kArmJointNames[i]);
    arm.finger = finder.joint(name.substr(0, 1) + "_gripper_l_finger_joint");
    arm.endpoint = finder.link(name + "_gripper");
  }
  found.head_pan = finder.joint("head_pan");
  for (int i = 0; i < 4; ++i) found.wheels[i] = finder.joint(kWheelNames[i]);
  found.base = finder.link("base");
  if (!finder.missing().empty())
    return fail(ErrorCode::kNotFound,
                "robot '" + robot.name() + "' has no " + finder.missing() +
                    ": the simulator drives a mobile Baxter, see urdf/mobile_baxter.urdf");
  return found;
}

MotionLimits motion_limits(const Joint& joint, double max_accel) {
  return {joint.lower, joint.upper, joint.max_velocity, max_accel};
}

Result<std::vector<double>> start_positions(const RobotModel& robot, const RobotJoints& joints,
                                            const std::string& arm_pose) {
  const auto pose = left_poses().find(arm_pose);
  if (pose == left_poses().end())
    return fail(ErrorCode::kInvalidArgument,
                "unknown start pose '" + arm_pose + "': use untuck, tuck or neutral");
  std::vector<double> positions(robot.joints().size(), 0.0);
  for (const Side side : kSides) {
    const auto& arm = joints.arms[static_cast<int>(side)];
    const ArmValues values = side == Side::kLeft ? pose->second : mirrored(pose->second);
    for (int i = 0; i < kArmJoints; ++i) positions[arm.joints[i]] = values[i];
    positions[arm.finger] = robot.joints()[arm.finger].upper;
  }
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (const auto& mimic = robot.joints()[i].mimic)
      positions[i] = mimic->multiplier * positions[mimic->joint] + mimic->offset;
  return positions;
}

ArmJacobian arm_jacobian(const RobotModel& robot, const RobotJoints& joints, Side side,
                         const std::vector<Pose>& root_T_link) {
  const auto& arm = joints.arms[static_cast<int>(side)];
  const Pose base_T_root = root_T_link[joints.base].inverse();
  const Eigen::Vector3d tip = base_T_root * root_T_link[arm.endpoint].translation();
  ArmJacobian jacobian;
  for (int i = 0; i < kArmJoints; ++i) {
    const Joint& joint = robot.joints()[arm.joints[i]];
    // The child's frame has the joint's origin, and turns about the axis only.
    const Pose base_T_joint = base_T_root * root_T_link[joint.child_link];
    const Eigen::Vector3d axis = base_T_joint.linear() * joint.axis;
    jacobian.col(i) << axis.cross(tip - base_T_joint.translation()), axis;
  }
  return jacobian;
}

}  // namespace extperfc::simulate
