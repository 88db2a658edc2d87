#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "test/unit/simulate/bodies/bodies_world.hpp"

namespace extperfc::simulate {

inline int joint_index(const std::string& name) {
  return mobile_baxter().joint(name).value();
}
inline int link_index(const std::string& name) {
  return mobile_baxter().link(name).value();
}

/// All joints at 0, arms untucked, grippers open.
inline std::vector<double> untucked() {
  std::vector<double> positions(mobile_baxter().joints().size(), 0.0);
  const std::array<const char*, 7> names{"s0", "s1", "e0", "e1", "w0", "w1", "w2"};
  const std::array<double, 7> left{-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5};
  const std::array<double, 7> right{0.08, -1.0, 1.19, 1.94, -0.67, 1.03, 0.5};
  for (int i = 0; i < 7; ++i) {
    positions[joint_index(std::string("left_") + names[i])] = left[i];
    positions[joint_index(std::string("right_") + names[i])] = right[i];
  }
  positions[joint_index("l_gripper_l_finger_joint")] = 0.020833;
  positions[joint_index("r_gripper_l_finger_joint")] = 0.020833;
  return positions;
}

inline std::array<int, 7> arm_joints(const std::string& side) {
  std::array<int, 7> joints{};
  const std::array<const char*, 7> names{"s0", "s1", "e0", "e1", "w0", "w1", "w2"};
  for (int i = 0; i < 7; ++i) joints[i] = joint_index(side + "_" + names[i]);
  return joints;
}

/// Joint positions that bring <side>_gripper there, by damped least squares from `seed`.
inline std::vector<double> reach(const std::string& side, const Pose& root_T_gripper,
                                 std::vector<double> seed) {
  const auto joints = arm_joints(side);
  const int link = link_index(side + "_gripper");
  const auto error = [&](const std::vector<double>& q) {
    const Pose now = mobile_baxter().link_poses(q)[link];
    const Eigen::AngleAxisd rotation(Eigen::Matrix3d(root_T_gripper.linear() * now.linear().transpose()));
    Eigen::Matrix<double, 6, 1> e;
    e << root_T_gripper.translation() - now.translation(), rotation.angle() * rotation.axis();
    return e;
  };
  for (int iteration = 0; iteration < 200 && error(seed).norm() > 1e-7; ++iteration) {
    const auto e = error(seed);
    Eigen::Matrix<double, 6, 7> jacobian;
    for (int i = 0; i < 7; ++i) {
      auto moved = seed;
      moved[joints[i]] += 1e-6;
      jacobian.col(i) = (e - error(moved)) / 1e-6;
    }
    const Eigen::Matrix<double, 6, 6> damped =
        jacobian * jacobian.transpose() + 1e-4 * Eigen::Matrix<double, 6, 6>::Identity();
    const Eigen::Matrix<double, 7, 1> change = jacobian.transpose() * damped.ldlt().solve(e);
    for (int i = 0; i < 7; ++i) {
      const Joint& joint = mobile_baxter().joints()[joints[i]];
      seed[joints[i]] =
          std::clamp(seed[joints[i]] + std::clamp(change[i], -0.3, 0.3), joint.lower, joint.upper);
    }
  }
  if (error(seed).norm() > 1e-4) throw std::runtime_error("the test's pose is out of reach");
  return seed;
}

/// Gripper that points down with its fingers along y, its tip frame at `tip`.
inline Pose from_above(const Eigen::Vector3d& tip) {
  return make_pose(tip, {M_PI, 0, 0});
}

/// Moves the joints of a Bodies smoothly (cosine) from one posture to the next.
class JointDriver {
 public:
  JointDriver(Bodies& bodies, std::vector<double> start) : bodies_(&bodies), now_(std::move(start)) {
    send(now_, now_);
  }

  /// Calls `each_step` after every step.
  template <typename EachStep>
  void move(const std::vector<double>& goal, double duration_s, EachStep each_step) {
    const auto from = now_;
    const auto steps = static_cast<int>(std::lround(duration_s / kStep));
    for (int i = 1; i <= steps; ++i) {
      const double fraction = 0.5 - 0.5 * std::cos(M_PI * i / steps);
      auto next = from;
      for (std::size_t j = 0; j < next.size(); ++j) next[j] += fraction * (goal[j] - from[j]);
      send(next, now_);
      now_ = next;
      bodies_->step();
      each_step();
    }
    send(now_, now_);
  }
  void move(const std::vector<double>& goal, double duration_s) {
    move(goal, duration_s, [] {});
  }

  [[nodiscard]] const std::vector<double>& now() const { return now_; }

 private:
  void send(const std::vector<double>& next, const std::vector<double>& before) {
    for (std::size_t j = 0; j < next.size(); ++j)
      bodies_->set_target(static_cast<int>(j),
                          {Drive::kPosition, next[j], (next[j] - before[j]) / kStep, 0, 0});
  }

  Bodies* bodies_;
  std::vector<double> now_;
};

}  // namespace extperfc::simulate
