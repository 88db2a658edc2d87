#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "extperfc/arm/path_constraint.hpp"

#include "arm/constrained/blocks.hpp"
#include "arm/kinematics/check.hpp"
#include "arm/kinematics/geometry.hpp"

namespace extperfc::arm {

namespace {

constexpr double kMinAxis = 1e-9;

int rows_of(ToolConstraintKind kind) {
  switch (kind) {
    case ToolConstraintKind::kKeepAxis:
    case ToolConstraintKind::kKeepLine:
      return 2;
    case ToolConstraintKind::kKeepPlane:
      return 1;
    case ToolConstraintKind::kKeepOrientation:
      return 3;
    case ToolConstraintKind::kKeepRelative:
      return 6;
  }
  return 0;
}

bool needs_axis(ToolConstraintKind kind) {
  return kind == ToolConstraintKind::kKeepAxis || kind == ToolConstraintKind::kKeepPlane ||
         kind == ToolConstraintKind::kKeepLine;
}

/// Makes the blocks of one request, tool by tool.
class Builder {
 public:
  Builder(const RobotModel& robot, const PathConstraintParams& params) : robot_(robot), params_(params) {}

  Result<Blocks> build() {
    if (auto fine = check_group(); !fine) return tl::unexpected(fine.error());
    blocks_.joints = static_cast<int>(params_.joints.size());
    for (const auto& constraint : params_.constraints)
      if (auto added = add(constraint); !added) return tl::unexpected(added.error());
    if (blocks_.equations > kMaxEquations)
      return fail(ErrorCode::kInvalidArgument, std::to_string(blocks_.equations) + " equations; " +
                                                   std::to_string(kMaxEquations) + " at most");
    return std::move(blocks_);
  }

 private:
  Result<void> check_group() {
    if (params_.joints.empty() || params_.joints.size() > kMaxJoints)
      return fail(ErrorCode::kInvalidArgument,
                  "a group needs 1 to " + std::to_string(kMaxJoints) + " joints");
    for (const auto& name : params_.joints)
      if (!robot_.joint(name)) return fail(ErrorCode::kNotFound, "the robot has no joint '" + name + "'");
    for (const auto& [name, value] : params_.fixed_positions) {
      if (!robot_.joint(name)) return fail(ErrorCode::kNotFound, "the robot has no joint '" + name + "'");
      if (!std::isfinite(value))
        return fail(ErrorCode::kInvalidArgument, "the position of joint '" + name + "' is not finite");
    }
    if (params_.constraints.empty()) return fail(ErrorCode::kInvalidArgument, "no constraint was given");
    const auto size = static_cast<Eigen::Index>(params_.joints.size());
    if (params_.reference.size() != 0 && (params_.reference.size() != size || !params_.reference.allFinite()))
      return fail(ErrorCode::kInvalidArgument,
                  "the reference needs " + std::to_string(size) + " finite joint values");
    return {};
  }

  [[nodiscard]] double standing_value(int joint) const {
    const Joint& own = robot_.joints()[joint];
    const auto named = params_.fixed_positions.find(own.name);
    if (named != params_.fixed_positions.end()) return named->second;
    return std::clamp(0.0, own.lower, own.upper);
  }

  [[nodiscard]] int group_index(int joint) const {
    const auto& names = params_.joints;
    const auto found = std::find(names.begin(), names.end(), robot_.joints()[joint].name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }

  /// Whether a joint of the group carries the link.
  [[nodiscard]] bool is_carried(const std::string& link) const {
    for (int at = *robot_.link(link); robot_.links()[at].parent_joint >= 0;) {
      const int joint = robot_.links()[at].parent_joint;
      if (robot_.joints()[joint].type != JointType::kFixed && group_index(joint) >= 0) return true;
      at = robot_.joints()[joint].parent_link;
    }
    return false;
  }

  /// Index in blocks_.tools.
  Result<int> tool_of(const std::string& link) {
    const auto known = tools_.find(link);
    if (known != tools_.end()) return known->second;
    const auto chain = ArmChain::make(robot_, robot_.links().front().name, link);
    if (!chain) return tl::unexpected(chain.error());
    Tool tool{*chain, {}, JointVector::Zero(chain->joint_count()), {}, 0};
    const auto& geometry = chain->geometry();
    tool.reach_m = geometry.links[geometry.count].offset_m.norm();
    for (int j = 0; j < chain->joint_count(); ++j) {
      const int joint = chain->robot_joints()[j];
      tool.group_joint.push_back(group_index(joint));
      tool.standing[j] = standing_value(joint);
      tool.prismatic.push_back(geometry.prismatic[j]);
      tool.reach_m += geometry.links[j].offset_m.norm();
      if (geometry.prismatic[j])
        tool.reach_m += std::max(std::abs(chain->limits().lower[j]), std::abs(chain->limits().upper[j]));
    }
    blocks_.tools.push_back(std::move(tool));
    return tools_[link] = static_cast<int>(blocks_.tools.size()) - 1;
  }

  /// Of a link that no joint of the group carries.
  [[nodiscard]] Pose standing_pose(const std::string& link) const {
    std::vector<double> positions;
    positions.reserve(robot_.joints().size());
    for (int j = 0; j < static_cast<int>(robot_.joints().size()); ++j)
      positions.push_back(robot_.joints()[j].type == JointType::kFixed ? 0.0 : standing_value(j));
    return robot_.link_poses(positions)[static_cast<std::size_t>(*robot_.link(link))];
  }

  Result<void> add_tools(Block* block) {
    const auto& own = block->constraint;
    if (!robot_.link(own.link)) return fail(ErrorCode::kNotFound, "the robot has no link '" + own.link + "'");
    if (!is_carried(own.link))
      return fail(ErrorCode::kInvalidArgument, "no joint of the group moves link '" + own.link + "'");
    const auto tool = tool_of(own.link);
    if (!tool) return tl::unexpected(tool.error());
    block->tool = *tool;
    if (own.kind != ToolConstraintKind::kKeepRelative) return {};
    if (!robot_.link(own.other_link))
      return fail(ErrorCode::kNotFound, "the robot has no link '" + own.other_link + "'");
    if (own.other_link == own.link)
      return fail(ErrorCode::kInvalidArgument, "link '" + own.link + "' keeps its pose to itself anyway");
    if (!is_carried(own.other_link)) {
      block->root_T_other = standing_pose(own.other_link);
      return {};
    }
    const auto other = tool_of(own.other_link);
    if (!other) return tl::unexpected(other.error());
    block->other_tool = *other;
    return {};
  }

  [[nodiscard]] Pose pose_at_reference(int tool) const {
    const Tool& own = blocks_.tools[static_cast<std::size_t>(tool)];
    return own.chain.forward(own.chain_joints(params_.reference));
  }

  Result<void> add_target(Block* block) const {
    auto& target = block->constraint.target;
    if (target && !is_rigid(*target))
      return fail(ErrorCode::kInvalidArgument,
                  "the target of link '" + block->constraint.link + "' is no rigid transform");
    if (target) return {};
    if (params_.reference.size() == 0)
      return fail(ErrorCode::kInvalidArgument,
                  "link '" + block->constraint.link + "' has no target and there is no reference");
    target = pose_at_reference(block->tool);
    if (block->constraint.kind != ToolConstraintKind::kKeepRelative) return {};
    const Pose other = block->other_tool < 0 ? block->root_T_other : pose_at_reference(block->other_tool);
    target = other.inverse() * *target;
    return {};
  }

  Result<void> add(const ToolConstraint& constraint) {
    Block block;
    block.constraint = constraint;
    block.rows = rows_of(constraint.kind);
    block.first_row = blocks_.equations;
    if (block.rows == 0) return fail(ErrorCode::kInvalidArgument, "an unknown kind of constraint");
    if (needs_axis(constraint.kind)) {
      if (!constraint.axis.allFinite() || constraint.axis.norm() < kMinAxis)
        return fail(ErrorCode::kInvalidArgument,
                    "the axis for link '" + constraint.link + "' needs finite values and a length above 0");
      block.constraint.axis = constraint.axis.normalized();
    }
    if (auto added = add_tools(&block); !added) return added;
    if (auto added = add_target(&block); !added) return added;
    block.direction = constraint.kind == ToolConstraintKind::kKeepAxis
                          ? Eigen::Vector3d(block.constraint.target->linear() * block.constraint.axis)
                          : block.constraint.axis;
    block.across.col(0) = block.direction.unitOrthogonal();
    block.across.col(1) = block.direction.cross(block.across.col(0));
    blocks_.equations += block.rows;
    blocks_.constraints.push_back(block.constraint);
    blocks_.blocks.push_back(std::move(block));
    return {};
  }

  const RobotModel& robot_;
  const PathConstraintParams& params_;
  Blocks blocks_;
  std::map<std::string, int> tools_;
};

}  // namespace

Result<Blocks> make_blocks(const RobotModel& robot, const PathConstraintParams& params) {
  return Builder(robot, params).build();
}

}  // namespace extperfc::arm
