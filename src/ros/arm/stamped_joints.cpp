#include "ros/arm/stamped_joints.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace extperfc::ros_arm {

using arm::JointVector;

namespace {

constexpr double kSpan = 3.0;     ///< of the history [s]
constexpr double kWait = 0.2;     ///< maximum wait for joint states as new as the stamp [s of wall time]
constexpr double kBeyond = 0.05;  ///< maximum age of joint states at the stamp [s]

/// "both_arms", or else the group with the most joints.
const arm::ArmGroup& widest_group(const arm::RobotArms& arms) {
  if (const auto both = arms.group("both_arms")) return **both;
  return *std::max_element(arms.groups().begin(), arms.groups().end(),
                           [](const auto& a, const auto& b) { return a.joints.size() < b.joints.size(); });
}

/// Whether one of `joints` carries the joint.
bool carried_by(const RobotModel& robot, int joint, const std::vector<std::string>& joints) {
  while ((joint = robot.links()[robot.joints()[joint].parent_link].parent_joint) >= 0)
    if (std::find(joints.begin(), joints.end(), robot.joints()[joint].name) != joints.end()) return true;
  return false;
}

/// The arms' joints, and those of the grippers up to kMaxJoints.
std::vector<std::string> watched_joints(const arm::RobotArms& arms) {
  const auto& own = widest_group(arms).joints;
  std::vector<std::string> joints = own;
  for (int i = 0; i < static_cast<int>(arms.robot().joints().size()); ++i) {
    const Joint& joint = arms.robot().joints()[i];
    const bool known = std::find(own.begin(), own.end(), joint.name) != own.end();
    if (joint.type == JointType::kFixed || joint.mimic || known || !carried_by(arms.robot(), i, own))
      continue;
    if (joints.size() < static_cast<std::size_t>(arm::kMaxJoints)) joints.push_back(joint.name);
  }
  return joints;
}

/// Initial positions: NaN for joints of the arms, which must be published; 0, or the nearest limit, for those
/// of grippers.
JointVector unheard(const arm::RobotArms& arms, const arm::CollisionModel& model) {
  const std::size_t own = widest_group(arms).joints.size();
  JointVector initial = JointVector::Constant(model.joint_count(), std::numeric_limits<double>::quiet_NaN());
  for (auto i = static_cast<Eigen::Index>(own); i < initial.size(); ++i)
    initial[i] = std::clamp(0.0, model.limits().lower[i], model.limits().upper[i]);
  return initial;
}

}  // namespace

Result<std::unique_ptr<StampedJoints>> StampedJoints::make(const arm::RobotArms& arms) {
  arm::CollisionModelParams shapes;
  shapes.joints = watched_joints(arms);
  const auto model = arm::CollisionModel::make(arms.robot(), shapes);
  if (!model) return tl::unexpected(model.error());
  return std::unique_ptr<StampedJoints>(new StampedJoints(arms, *model));
}

StampedJoints::StampedJoints(const arm::RobotArms& arms, const arm::CollisionModel& model)
    : model_(model), history_(model.joint_names(), unheard(arms, model), kSpan) {}

void StampedJoints::start(ros::NodeHandle handle) {
  subscriber_ = handle.subscribe("robot/joint_states", 20, &StampedJoints::on_joints, this,
                                 ros::TransportHints().tcpNoDelay());
}

void StampedJoints::close() {
  subscriber_.shutdown();
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
}

void StampedJoints::on_joints(const sensor_msgs::JointStateConstPtr& message) {
  const std::lock_guard lock(mutex_);
  history_.add(message->header.stamp.toSec(), message->name, message->position);
  changed_.notify_all();
}

Result<JointVector> StampedJoints::at(const ros::Time& stamp) {
  const double time_s = stamp.toSec();
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(kWait),
                    [&] { return closing_ || history_.newest_s() >= time_s; });
  if (const auto positions = history_.at(time_s, kBeyond)) return *positions;
  if (!std::isfinite(history_.newest_s()))
    return fail(ErrorCode::kNotFound, "robot/joint_states has not contained all joints of the arms yet");
  return fail(ErrorCode::kNotFound,
              "no joint states at the stamp of the camera: is robot/joint_states published, and are the "
              "clocks synchronized?");
}

double StampedJoints::newest_s() const {
  const std::lock_guard lock(mutex_);
  return history_.newest_s();
}

}  // namespace extperfc::ros_arm
