#include "simulate/bodies/robot_body.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace extperfc::simulate {

RobotBody::RobotBody(const RobotPlan& plan, std::vector<double> start_positions)
    : plan_(&plan),
      targets_(start_positions.size()),
      positions_(std::move(start_positions)),
      velocities_(positions_.size(), 0.0),
      speed_limits_(positions_.size()) {
  const auto& joints = plan.model->joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    positions_[i] = followed_position(*plan.model, static_cast<int>(i), positions_);
    targets_[i].position = positions_[i];
    speed_limits_[i] = joints[i].max_velocity > 0 ? joints[i].max_velocity : 10.0;
  }
  for (const GripperFingers& gripper : plan.grippers)
    for (const int joint : {gripper.joint, gripper.mimic_joint})
      speed_limits_[joint] = std::min(speed_limits_[joint], kFingerSpeed);
}

void RobotBody::set_target(int joint, const JointTarget& target) {
  if (!std::isfinite(target.position) || !std::isfinite(target.velocity) || !std::isfinite(target.effort) ||
      !std::isfinite(target.max_effort))
    return;
  const Joint& j = plan_->model->joints()[joint];
  targets_[joint] = target;
  targets_[joint].position = std::clamp(target.position, j.lower, j.upper);
}

void RobotBody::set_state(int joint, double position, double velocity) {
  positions_[joint] = position;
  velocities_[joint] = velocity;
}

}  // namespace extperfc::simulate
