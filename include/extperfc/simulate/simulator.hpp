#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/bodies.hpp"
#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::simulate {

/// Wheels, odometry and IMU of the holonomic base.
struct BaseParams {
  double max_speed_m_s{1.0};            ///< along x and y together, (0, 1.84]
  double max_yaw_rate_rad_s{1.5};       ///< (0, 3.1]
  double max_accel_m_s2{1.0};           ///< (0, 4]
  double max_yaw_accel_rad_s2{3.1416};  ///< (0, 9.5]
  double command_timeout_s{0.2};        ///< the base stops when no command came for this long, (0, 5]
  /// Standard deviation of the error of a wheel's measured speed, as a fraction of it, [0, 0.5]. It wanders
  /// with a correlation time of 0.5 s.
  double wheel_noise{0.01};
  /// The same of the fraction of a wheel's motion that the floor does not take.
  double wheel_slip{0.01};
  double lateral_slip{0.02};       ///< fraction of sideways motion that mecanum rollers lose, [0, 0.5]
  double gyro_noise_rad_s{0.002};  ///< standard deviation of a sample, [0, 1]
  double gyro_bias_rad_s{
      0.001};  ///< standard deviation of the constant bias, drawn once from the seed, [0, 1]
  double accel_noise_m_s2{0.02};  ///< standard deviation of a sample, [0, 10]
};

struct ArmParams {
  double max_accel_rad_s2{4.0};      ///< of every joint's set point, (0, 50]
  double command_timeout_s{0.2};     ///< as on Baxter
  std::string start_pose{"untuck"};  ///< untuck, tuck or neutral
};

struct SimulatorParams {
  std::uint64_t seed{1};
  BodiesParams bodies;
  BaseParams base;
  ArmParams arms;
  bool start_enabled{false};  ///< as after `enable_robot -e`
};

/// Where everything is at one instant: all that sensors need. Immutable once taken.
struct Snapshot {
  double time_s{0};
  std::vector<Pose> world_T_link;     ///< by RobotModel::links()
  std::vector<Pose> world_T_body;     ///< by WorldSpec::bodies
  std::vector<Pose2> world_T_person;  ///< by WorldSpec::people
};

/// The robot in its world, stepped by the caller. No thread, no wall clock, no global
/// state: one thread at a time. The same seed, the same calls in the same order give the same states, bit for
/// bit, on one build.
class Simulator {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Simulator>> make(const SimulatorParams& params,
                                                               RobotModel robot, WorldSpec world);
  virtual ~Simulator() = default;

  /// Advances by params.bodies.step_s.
  virtual void step() = 0;
  /// Back to the start: poses, commands, faults, time, random numbers.
  virtual Result<void> reset() = 0;
  [[nodiscard]] virtual double time_s() const = 0;
  [[nodiscard]] virtual const SimulatorParams& params() const = 0;
  [[nodiscard]] virtual const RobotModel& robot() const = 0;
  [[nodiscard]] virtual const WorldSpec& world() const = 0;

  // Commands. A disabled or stopped robot's arms and head do not move; grippers and arms ignore commands
  // then.
  virtual void enable(bool on) = 0;  ///< refused (state unchanged) while stopped
  virtual void stop() = 0;           ///< e-stop: disabled until reset_stop()
  virtual void reset_stop() = 0;
  /// Error: a value that is not finite; kTorque in kinematic mode.
  [[nodiscard]] virtual Result<void> command_arm(Side side, const ArmCommand& command) = 0;
  virtual void set_speed_ratio(Side side, double ratio) = 0;      ///< of position moves, clamped to [0, 1]
  virtual void set_arm_timeout(Side side, double timeout_s) = 0;  ///< clamped to (0, 1]
  [[nodiscard]] virtual Result<void> command_gripper(Side side, const GripperCommand& command) = 0;
  virtual void command_head_pan(double target_rad,
                                double speed_ratio) = 0;  ///< clamped to the joint's limits
  virtual void command_head_nod() = 0;
  virtual void command_base(const Twist2& velocity) = 0;  ///< not finite: ignored

  [[nodiscard]] virtual RobotState robot_state() const = 0;
  [[nodiscard]] virtual ArmState arm_state(Side side) const = 0;
  [[nodiscard]] virtual GripperState gripper_state(Side side) const = 0;
  [[nodiscard]] virtual HeadState head_state() const = 0;
  [[nodiscard]] virtual BaseState base_state() const = 0;
  [[nodiscard]] virtual ImuSample imu() const = 0;  ///< of the last step
  [[nodiscard]] virtual JointSample joints()
      const = 0;  ///< every joint that is not fixed, mimic joints included
  [[nodiscard]] virtual Snapshot snapshot() const = 0;

  /// Name in WorldSpec::bodies; the pose is in the world. Errors: no such body, it is fixed.
  [[nodiscard]] virtual Result<void> move_body(const std::string& name, const Pose& world_T_body) = 0;
  /// Puts the robot elsewhere, at rest; odometry goes on from where it was.
  virtual void move_robot(const Pose2& pose) = 0;

  /// Starts a fault, or ends it (kind kNone: all of them; duration below 0: this kind). Errors: unknown
  /// target, value out of its range.
  [[nodiscard]] virtual Result<void> set_fault(const Fault& fault) = 0;
  /// Faults that are active now.
  [[nodiscard]] virtual std::vector<Fault> faults() const = 0;
};

}  // namespace extperfc::simulate
