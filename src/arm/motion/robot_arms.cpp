#include "extperfc/arm/robot_arms.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace extperfc::arm {

namespace {

const SrdfGroup* find_group(const Srdf& srdf, const std::string& name) {
  const auto found = std::find_if(srdf.groups.begin(), srdf.groups.end(),
                                  [&](const SrdfGroup& group) { return group.name == name; });
  return found == srdf.groups.end() ? nullptr : &*found;
}

/// Tips of a group's chains and of the groups within it.
void collect_tips(const Srdf& srdf, const SrdfGroup& group, std::vector<std::string>* tips) {
  for (const auto& [base, tip] : group.chains) tips->push_back(tip);
  for (const auto& inner : group.groups)
    if (const auto* found = find_group(srdf, inner)) collect_tips(srdf, *found, tips);
}

/// A group and the groups within it.
void collect_groups(const Srdf& srdf, const std::string& name, std::set<std::string>* names) {
  if (!names->insert(name).second) return;
  if (const auto* group = find_group(srdf, name))
    for (const auto& inner : group->groups) collect_groups(srdf, inner, names);
}

template <typename Names>
std::string listed(const Names& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

Result<void> check_joint(const Joint& joint) {
  if (!(joint.max_velocity > 0) || !std::isfinite(joint.max_velocity))
    return fail(
        ErrorCode::kInvalidArgument,
        "joint " + joint.name + " has no velocity limit: add <limit velocity=...> to the robot description");
  if (joint.type != JointType::kContinuous && !(std::isfinite(joint.lower) && std::isfinite(joint.upper)))
    return fail(
        ErrorCode::kInvalidArgument,
        "joint " + joint.name + " has no limits: add <limit lower=... upper=...> to the robot description");
  if (joint.type != JointType::kContinuous && !(joint.lower < joint.upper))
    return fail(ErrorCode::kInvalidArgument,
                "joint " + joint.name + " cannot move: its lower and upper limit are the same");
  return {};
}

Result<ArmGroup> make_group(const RobotModel& robot, const Srdf& srdf, const SrdfGroup& group,
                            const RobotArmsParams& params) {
  auto joints = joints_of_group(srdf, robot, group.name);
  if (!joints) return tl::unexpected(joints.error());
  if (joints->empty() || joints->size() > static_cast<std::size_t>(kMaxJoints))
    return fail(ErrorCode::kUnsupported, "group " + group.name + " has " + std::to_string(joints->size()) +
                                             " moving joints; 1 to " + std::to_string(kMaxJoints) +
                                             " are possible");
  ArmGroup made{group.name, *joints, {}, {}, {}};
  collect_tips(srdf, group, &made.tips);
  const auto count = static_cast<Eigen::Index>(joints->size());
  made.max_velocity.resize(count);
  made.max_acceleration.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& name = (*joints)[static_cast<std::size_t>(i)];
    const Joint& joint = robot.joints()[static_cast<std::size_t>(*robot.joint(name))];
    if (auto ok = check_joint(joint); !ok) return tl::unexpected(ok.error());
    made.max_velocity[i] = joint.max_velocity;
    const auto given = params.max_acceleration.find(name);
    made.max_acceleration[i] =
        given == params.max_acceleration.end() ? params.default_max_acceleration : given->second;
  }
  return made;
}

Result<void> check(const RobotModel& robot, const RobotArmsParams& params) {
  if (!(params.default_max_acceleration > 0) || !std::isfinite(params.default_max_acceleration))
    return fail(ErrorCode::kInvalidArgument, "the default acceleration limit must be above 0");
  for (const auto& [name, value] : params.max_acceleration) {
    if (!robot.joint(name))
      return fail(ErrorCode::kNotFound,
                  "an acceleration limit is given for " + name + ", which is no joint of " + robot.name());
    if (!(value > 0) || !std::isfinite(value))
      return fail(ErrorCode::kInvalidArgument, "the acceleration limit of " + name + " must be above 0");
  }
  return {};
}

}  // namespace

Result<RobotArms> RobotArms::make(const RobotModel& robot, const Srdf& srdf, const RobotArmsParams& params) {
  if (auto ok = check(robot, params); !ok) return tl::unexpected(ok.error());
  std::vector<ArmGroup> groups;
  for (const auto& group : srdf.groups) {
    std::vector<std::string> tips;
    collect_tips(srdf, group, &tips);
    if (tips.empty()) continue;
    auto made = make_group(robot, srdf, group, params);
    if (!made) return tl::unexpected(made.error());
    groups.push_back(std::move(*made));
  }
  if (groups.empty())
    return fail(ErrorCode::kInvalidArgument, "the SRDF of " + srdf.robot + " has no group with a chain");
  return RobotArms(std::make_shared<const Data>(Data{robot, srdf, std::move(groups)}));
}

Result<const ArmGroup*> RobotArms::group(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& group : data_->groups) {
    if (group.name == name) return &group;
    known.push_back(group.name);
  }
  return fail(ErrorCode::kNotFound, "there is no group '" + name + "': use one of " + listed(known));
}

Result<JointPositions> RobotArms::named_state(const ArmGroup& group, const std::string& state) const {
  std::set<std::string> within, known;
  collect_groups(data_->srdf, group.name, &within);
  JointPositions all;
  for (const auto& one : data_->srdf.states) {
    if (within.count(one.group) == 0) continue;
    known.insert(one.name);
    if (one.name == state) all.insert(one.positions.begin(), one.positions.end());
  }
  if (known.count(state) == 0)
    return fail(ErrorCode::kNotFound,
                "group " + group.name + " has no state '" + state + "': use one of " + listed(known));
  const auto silent_about = [&](const std::string& joint) {
    return "the state " + state + " has no value for " + joint;
  };
  JointPositions result;
  for (const auto& joint : group.joints) {
    const auto found = all.find(joint);
    if (found == all.end()) return fail(ErrorCode::kInvalidArgument, silent_about(joint));
    result.insert(*found);
  }
  return result;
}

Result<JointVector> RobotArms::select(const ArmGroup& group, const JointPositions& positions) {
  JointVector values(static_cast<Eigen::Index>(group.joints.size()));
  for (std::size_t i = 0; i < group.joints.size(); ++i) {
    const auto found = positions.find(group.joints[i]);
    if (found == positions.end())
      return fail(ErrorCode::kNotFound, "no position is known of joint " + group.joints[i]);
    values[static_cast<Eigen::Index>(i)] = found->second;
  }
  return values;
}

Result<Pose> RobotArms::link_pose(const std::string& link, const JointPositions& positions) const {
  const auto index = data_->robot.link(link);
  if (!index) return fail(ErrorCode::kNotFound, data_->robot.name() + " has no link " + link);
  std::vector<double> values;
  for (const auto& joint : data_->robot.joints()) {
    const auto found = positions.find(joint.name);
    values.push_back(found != positions.end()          ? found->second
                     : joint.type == JointType::kFixed ? 0.0
                                                       : std::clamp(0.0, joint.lower, joint.upper));
  }
  return data_->robot.link_poses(values)[static_cast<std::size_t>(*index)];
}

}  // namespace extperfc::arm
