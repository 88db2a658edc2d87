#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "extperfc/simulate/simulator.hpp"

#include "simulate/control/robot_joints.hpp"

namespace extperfc::simulate {

/// Moves an arm of a simulated robot as a simple program would: straight lines of the end point, joint
/// commands.
class ArmDriver {
 public:
  ArmDriver(Simulator& simulator, Side side)
      : simulator_(simulator), side_(side), joints_(*find_joints(simulator.robot())) {
    simulator_.set_speed_ratio(side_, 1.0);
    // The right arm's and the head's joints do not matter to this arm's end point.
    positions_.assign(simulator.robot().joints().size(), 0.0);
    for (int i = 0; i < kArmJoints; ++i) positions_[arm().joints[i]] = simulator.arm_state(side).position[i];
  }

  /// The end point goes along a straight line, 0.15 m/s; false when it cannot.
  [[nodiscard]] bool line_to(const Pose& base_T_goal) {
    const Pose start = endpoint(positions_);
    const Eigen::Vector3d motion = base_T_goal.translation() - start.translation();
    const Eigen::Quaterniond from(start.linear());
    const Eigen::Quaterniond to(base_T_goal.linear());
    const double angle = from.angularDistance(to);
    const int ticks = 1 + static_cast<int>(std::ceil(std::max(motion.norm() / 0.15, angle / 0.8) * kRateHz));
    for (int i = 1; i <= ticks; ++i) {
      const double done = static_cast<double>(i) / ticks;
      Pose via = Pose::Identity();
      via.linear() = from.slerp(done, to).toRotationMatrix();
      via.translation() = start.translation() + done * motion;
      if (!solve(via)) return false;
      hold(1.0 / kRateHz);
    }
    hold(0.3);
    return true;
  }

  /// Holds the arm where it was sent for a while; `each` is called in every tick.
  template <typename Each>
  void hold(double seconds, Each each) {
    ArmCommand command{ArmMode::kRawPosition, {}};
    for (int i = 0; i < kArmJoints; ++i) command.values[i] = positions_[arm().joints[i]];
    const int steps_per_tick =
        static_cast<int>(std::lround(1.0 / kRateHz / simulator_.params().bodies.step_s));
    for (int i = 0; i < std::max(1L, std::lround(seconds * kRateHz)); ++i) {
      ASSERT_TRUE(simulator_.command_arm(side_, command));
      for (int step = 0; step < steps_per_tick; ++step) simulator_.step();
      each();
    }
  }
  void hold(double seconds) {
    hold(seconds, [] {});
  }

  [[nodiscard]] Pose goal() const { return endpoint(positions_); }

 private:
  static constexpr double kRateHz = 60;

  [[nodiscard]] const RobotJoints::Arm& arm() const { return joints_.arms[static_cast<int>(side_)]; }

  [[nodiscard]] Pose endpoint(const std::vector<double>& positions) const {
    const auto links = simulator_.robot().link_poses(positions);
    return links[joints_.base].inverse() * links[arm().endpoint];
  }

  /// Newton steps on the pose's error, damped; from where the arm is.
  [[nodiscard]] bool solve(const Pose& wanted) {
    for (int i = 0; i < 50; ++i) {
      const auto links = simulator_.robot().link_poses(positions_);
      const Pose now = links[joints_.base].inverse() * links[arm().endpoint];
      const Eigen::AngleAxisd rotation(wanted.linear() * now.linear().transpose());
      Eigen::Matrix<double, 6, 1> error;
      error << wanted.translation() - now.translation(), rotation.angle() * rotation.axis();
      if (error.norm() < 1e-6) return true;
      const ArmJacobian jacobian = arm_jacobian(simulator_.robot(), joints_, side_, links);
      const Eigen::Matrix<double, 6, 6> damped =
          jacobian * jacobian.transpose() + 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
      const Eigen::Matrix<double, kArmJoints, 1> change = jacobian.transpose() * damped.ldlt().solve(error);
      for (int j = 0; j < kArmJoints; ++j) {
        const Joint& joint = simulator_.robot().joints()[arm().joints[j]];
        double& position = positions_[arm().joints[j]];
        position = std::clamp(position + change[j], joint.lower, joint.upper);
      }
    }
    return false;
  }

  Simulator& simulator_;
  Side side_;
  RobotJoints joints_;
  std::vector<double> positions_;
};

}  // namespace extperfc::simulate
