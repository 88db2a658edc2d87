#include "extperfc/arm/collision_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "extperfc/world/frame_about.hpp"

#include "arm/collision/bodies.hpp"

namespace extperfc::arm {

void AllowedPairs::allow(const std::string& a, const std::string& b) {
  pairs_.insert(std::minmax(a, b));
}

void AllowedPairs::allow(const AllowedPairs& other) {
  pairs_.insert(other.pairs_.begin(), other.pairs_.end());
}

bool AllowedPairs::allows(const std::string& a, const std::string& b) const {
  return pairs_.count(std::minmax(a, b)) != 0;
}

namespace {

Result<void> check_range(double value, double low, double high, const char* name) {
  if (value >= low && value <= high) return {};
  return fail(ErrorCode::kInvalidArgument, std::string(name) + " is " + std::to_string(value) +
                                               ", it must be from " + std::to_string(low) + " to " +
                                               std::to_string(high));
}

Result<void> check_numbers(const CollisionModelParams& params, const RobotModel& robot) {
  constexpr double kMaxPadding = 1;
  if (auto ok = check_range(params.world_padding_m, 0, kMaxPadding, "world_padding_m"); !ok) return ok;
  if (auto ok = check_range(params.self_padding_m, 0, kMaxPadding, "self_padding_m"); !ok) return ok;
  if (auto ok = check_range(params.sphere_excess_m, 0.002, 0.1, "sphere_excess_m"); !ok) return ok;
  for (const auto& [link, padding] : params.link_padding_m) {
    if (!robot.link(link)) return fail(ErrorCode::kInvalidArgument, "link_padding_m: no link " + link);
    if (auto ok = check_range(padding, 0, kMaxPadding, "link_padding_m"); !ok) return ok;
  }
  for (const auto& [joint, position] : params.fixed_positions)
    if (!robot.joint(joint) || !std::isfinite(position))
      return fail(ErrorCode::kInvalidArgument, "fixed_positions: no joint " + joint + ", or not finite");
  return {};
}

/// Index into a JointVector for every joint of the robot, -1 for those that do not move.
Result<std::vector<int>> index_moving_joints(const CollisionModelParams& params, const RobotModel& robot) {
  if (params.joints.empty() || params.joints.size() > kMaxJoints)
    return fail(ErrorCode::kInvalidArgument, "a group has 1 to " + std::to_string(kMaxJoints) +
                                                 " joints, not " + std::to_string(params.joints.size()));
  std::vector<int> moving(robot.joints().size(), -1);
  for (std::size_t i = 0; i < params.joints.size(); ++i) {
    const auto index = robot.joint(params.joints[i]);
    if (!index) return fail(ErrorCode::kNotFound, "the robot has no joint " + params.joints[i]);
    const Joint& joint = robot.joints()[*index];
    if (joint.type == JointType::kFixed || joint.mimic || moving[*index] >= 0)
      return fail(ErrorCode::kInvalidArgument,
                  "joint " + joint.name + " is fixed, mimics another or is named twice");
    moving[*index] = static_cast<int>(i);
  }
  return moving;
}

/// Builds Bodies joint by joint; a parent link stands before its children.
class Builder {
 public:
  Builder(const RobotModel& robot, const CollisionModelParams& params, std::vector<int> moving)
      : robot_(robot), moving_(std::move(moving)) {
    bodies_.params = params;
    bodies_.joint_names = params.joints;
    const auto count = static_cast<Eigen::Index>(params.joints.size());
    bodies_.limits = {JointVector::Zero(count), JointVector::Zero(count)};
    bodies_.bodies.emplace_back();
    const std::size_t links = robot.links().size();
    bodies_.body_of_link.assign(links, 0);
    bodies_.body_T_link.assign(links, Pose::Identity());
  }

  Result<std::shared_ptr<const Bodies>> build() {
    for (std::size_t i = 0; i < robot_.joints().size(); ++i) place_child(static_cast<int>(i));
    for (std::size_t i = 0; i < robot_.links().size(); ++i)
      if (auto done = add_parts(static_cast<int>(i)); !done) return tl::unexpected<Error>(done.error());
    return std::make_shared<const Bodies>(std::move(bodies_));
  }

 private:
  [[nodiscard]] double fixed_position(const Joint& joint) const {
    const auto& given = bodies_.params.fixed_positions;
    if (const auto found = given.find(joint.name); found != given.end()) return found->second;
    return std::clamp(0.0, joint.lower, joint.upper);
  }

  void place_child(int index) {
    const Joint& joint = robot_.joints()[index];
    const int driver = joint.mimic ? joint.mimic->joint : index;
    const int parent = bodies_.body_of_link[joint.parent_link];
    const Pose parent_T_joint = bodies_.body_T_link[joint.parent_link] * joint.parent_T_joint;
    if (joint.type != JointType::kFixed && moving_[driver] >= 0)
      return add_body(joint, driver, parent, parent_T_joint);
    Pose motion = Pose::Identity();
    if (joint.type != JointType::kFixed) {
      double value = fixed_position(robot_.joints()[driver]);
      if (joint.mimic) value = joint.mimic->multiplier * value + joint.mimic->offset;
      if (joint.type == JointType::kPrismatic)
        motion.translation() = value * joint.axis;
      else
        motion.linear() = Eigen::AngleAxisd(value, joint.axis).toRotationMatrix();
    }
    bodies_.body_of_link[joint.child_link] = parent;
    bodies_.body_T_link[joint.child_link] = parent_T_joint * motion;
  }

  void add_body(const Joint& joint, int driver, int parent, const Pose& parent_T_joint) {
    Pose joint_T_rotated = Pose::Identity();
    joint_T_rotated.linear() = frame_about(joint.axis);
    Body body;
    body.parent = parent;
    body.joint = moving_[driver];
    if (joint.mimic) {
      body.multiplier = joint.mimic->multiplier;
      body.offset = joint.mimic->offset;
    } else {
      bodies_.limits.lower[body.joint] = joint.lower;
      bodies_.limits.upper[body.joint] = joint.upper;
    }
    const Joint& driving = robot_.joints()[driver];
    std::tie(body.lower, body.upper) = std::minmax(
        {body.multiplier * driving.lower + body.offset, body.multiplier * driving.upper + body.offset});
    body.prismatic = joint.type == JointType::kPrismatic;
    body.parent_T_joint = parent_T_joint * joint_T_rotated;
    bodies_.body_of_link[joint.child_link] = static_cast<int>(bodies_.bodies.size());
    bodies_.body_T_link[joint.child_link] = joint_T_rotated.inverse();
    bodies_.bodies.push_back(body);
  }

  Result<void> add_parts(int index) {
    const Link& link = robot_.links()[index];
    bodies_.links.push_back(link.name);
    const auto parts = make_convex_parts("link " + link.name, link.collisions);
    if (!parts) return tl::unexpected<Error>(parts.error());
    for (const auto& part : *parts) {
      LinkPart placed{
          index, bodies_.body_of_link[index], part, bodies_.body_T_link[index] * part->body_T_part, {}};
      if (placed.body > 0) placed.cover = sphere_cover(*part, bodies_.params.sphere_excess_m);
      bodies_.parts.push_back(std::move(placed));
    }
    return {};
  }

  const RobotModel& robot_;
  std::vector<int> moving_;
  Bodies bodies_;
};

}  // namespace

Result<CollisionModel> CollisionModel::make(const RobotModel& robot, const CollisionModelParams& params) {
  if (auto ok = check_numbers(params, robot); !ok) return tl::unexpected<Error>(ok.error());
  auto moving = index_moving_joints(params, robot);
  if (!moving) return tl::unexpected<Error>(moving.error());
  auto bodies = Builder(robot, params, std::move(*moving)).build();
  if (!bodies) return tl::unexpected<Error>(bodies.error());
  return CollisionModel(std::move(*bodies));
}

int CollisionModel::joint_count() const {
  return static_cast<int>(bodies_->joint_names.size());
}

const std::vector<std::string>& CollisionModel::joint_names() const {
  return bodies_->joint_names;
}

const JointLimits& CollisionModel::limits() const {
  return bodies_->limits;
}

std::optional<Pose> CollisionModel::link_pose(const JointVector& positions, const std::string& link) const {
  const auto index = bodies_->link(link);
  if (!index || positions.size() != joint_count()) return std::nullopt;
  std::vector<Pose> poses;
  body_poses(*bodies_, positions.data(), poses);
  return poses[bodies_->body_of_link[*index]] * bodies_->body_T_link[*index];
}

int CollisionModel::sphere_count() const {
  std::size_t count = 0;
  for (const auto& part : bodies_->parts) count += part.cover.size();
  return static_cast<int>(count);
}

}  // namespace extperfc::arm
