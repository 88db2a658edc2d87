#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

/// What goes into the simulated robot and comes out of it: Baxter's interface without ROS.
namespace extperfc::simulate {

enum class Side { kLeft = 0, kRight = 1 };
inline constexpr std::array<Side, 2> kSides{Side::kLeft, Side::kRight};
inline constexpr int kArmJoints = 7;
/// s0 s1 e0 e1 w0 w1 w2, from the shoulder to the wrist.
inline constexpr std::array<const char*, kArmJoints> kArmJointNames{"s0", "s1", "e0", "e1", "w0", "w1", "w2"};
using ArmValues = std::array<double, kArmJoints>;

[[nodiscard]] inline const char* to_string(Side side) {
  return side == Side::kLeft ? "left" : "right";
}

/// Modes of baxter_core_msgs/JointCommand.
enum class ArmMode { kPosition = 1, kVelocity = 2, kTorque = 3, kRawPosition = 4 };

/// A command counts for `joint command timeout` (0.2 s); after that the arm holds its position. Joints
/// without a value hold theirs.
struct ArmCommand {
  ArmMode mode{ArmMode::kPosition};
  std::array<std::optional<double>, kArmJoints> values;  ///< [rad], [rad/s] or [N m]
};

struct ArmState {
  ArmValues position{};                    ///< [rad]
  ArmValues velocity{};                    ///< [rad/s]
  ArmValues effort{};                      ///< [N m]
  ArmValues gravity{};                     ///< effort that holds the arm against gravity [N m]
  ArmValues command{};                     ///< set point after rate and acceleration limits [rad]
  Pose base_T_endpoint{Pose::Identity()};  ///< <side>_gripper in Baxter's `base`
  Eigen::Matrix<double, 6, 1> twist{
      Eigen::Matrix<double, 6, 1>::Zero()};  ///< of the end point: v [m/s], w [rad/s], in base
  Eigen::Matrix<double, 6, 1> wrench{
      Eigen::Matrix<double, 6, 1>::Zero()};  ///< at the end point: f [N], t [N m], in base
};

/// Baxter's electric parallel gripper.
struct GripperCommand {
  enum class Kind { kNoop, kGoTo, kStop, kCalibrate, kClearCalibration, kReset, kReboot, kConfigure };
  Kind kind{Kind::kNoop};
  double position_percent{100};  ///< 0 closed, 100 open
  /// Empty: unchanged. [0, 100] each, as in Baxter's parameters.
  std::optional<double> velocity_percent, moving_force_percent, holding_force_percent, dead_zone_percent;
};

struct GripperState {
  bool calibrated{false};
  bool ready{false};
  bool moving{false};
  bool gripping{false};
  bool missed{false};
  bool error{false};
  double position_percent{0};  ///< 0 closed, 100 open
  double force_percent{0};
};

struct HeadState {
  double pan{0};  ///< [rad]
  bool turning{false};
  bool nodding{false};
};

/// baxter_core_msgs/AssemblyState.
struct RobotState {
  enum class Stop { kNone = 0, kUnknown = 1, kButton = 2, kFault = 3 };
  bool ready{true};
  bool enabled{false};
  bool stopped{false};
  bool error{false};
  Stop source{Stop::kNone};
};

struct BaseState {
  Pose2 truth;                             ///< in the world
  Pose2 odometry;                          ///< integrated from the wheels, with their noise and slip
  Twist2 velocity;                         ///< true, in the base's frame
  Twist2 measured;                         ///< from the wheels
  std::array<double, 4> wheel_position{};  ///< front left, front right, rear left, rear right [rad]
  std::array<double, 4> wheel_velocity{};  ///< [rad/s]
  bool blocked{false};                     ///< a wall or an object blocks it
};

struct ImuSample {
  Eigen::Vector3d acceleration{0, 0, 9.81};   ///< specific force in the IMU's frame [m/s^2]
  Eigen::Vector3d angular_velocity{0, 0, 0};  ///< [rad/s]
  double yaw{0};                              ///< integrated [rad], starts at 0
};

/// All joints that move, for sensor_msgs/JointState.
struct JointSample {
  std::vector<std::string> names;
  std::vector<double> position, velocity, effort;
};

/// A fault on demand. docs/simulation.md describes every target and value.
enum class FaultKind {
  kNone,
  kCameraFreeze,  ///< the same image again, with new stamps
  kCameraDrop,    ///< value: fraction of frames that are lost, [0, 1]
  kCameraNan,   ///< value: fraction of depth pixels without a measurement, [0, 1] (NaN in 32FC1, 0 in 16UC1)
  kLidarRings,  ///< target: ring numbers, e.g. "3,7"; their points are missing
  kLidarDrop,   ///< value: fraction of sweeps that are lost, [0, 1]
  kJointStuck,  ///< target: joint; it stays where it is
  kWheelSlip,   ///< target: fl, fr, rl, rr or all; value: fraction of its motion that is lost, [0, 1]
  kClockJump,   ///< value: seconds by which the clock jumps, once
  kDie,         ///< value: seconds until the process ends itself with exit code 1
};

/// Name as services and parameters write it: "camera_freeze", "camera_drop", "camera_nan", "lidar_rings",
/// "lidar_drop", "joint_stuck", "wheel_slip", "clock_jump", "die"; "none" ends every fault.
[[nodiscard]] const char* to_string(FaultKind kind);
[[nodiscard]] std::optional<FaultKind> fault_kind(const std::string& name);

/// Ring numbers of a kLidarRings target: "3,7"; every ring for "" and "all". Error: names the part that is
/// none of 0 to 15.
[[nodiscard]] Result<std::vector<int>> ring_numbers(const std::string& target);

struct Fault {
  FaultKind kind{FaultKind::kNone};
  std::string target;
  double value{1};
  double duration_s{0};  ///< 0: until it is cleared
};

}  // namespace extperfc::simulate
