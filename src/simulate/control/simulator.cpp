#include "extperfc/simulate/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/QR>

#include "simulate/control/arm_controller.hpp"
#include "simulate/control/fault_book.hpp"
#include "simulate/control/gripper_controller.hpp"
#include "simulate/control/head_controller.hpp"
#include "simulate/control/mobile_base.hpp"
#include "simulate/control/params_check.hpp"
#include "simulate/control/pedestrian.hpp"
#include "simulate/control/robot_joints.hpp"

namespace extperfc::simulate {
namespace {

/// The description's limits of head and fingers are placeholders (10,000 rad/s, 5 m/s): these are what the
/// real ones do.
constexpr double kHeadSpeed = 1.0;      // [rad/s]
constexpr double kHeadAccel = 4.0;      // [rad/s^2]
constexpr double kGripperSpeed = 0.08;  // [m/s]
constexpr double kFingerAccel = 1.0;    // [m/s^2]

/// Everything that moves, as it is after a start; made anew by a reset.
struct Parts {
  std::unique_ptr<Bodies> bodies;
  MobileBase base;
  std::vector<Pedestrian> people;
  std::vector<ArmController> arms;
  std::vector<GripperController> grippers;
  HeadController head;
  FaultBook faults;
};

std::array<MotionLimits, kArmJoints> arm_limits(const RobotModel& robot, const RobotJoints::Arm& arm,
                                                double accel) {
  std::array<MotionLimits, kArmJoints> limits;
  for (int i = 0; i < kArmJoints; ++i) limits[i] = motion_limits(robot.joints()[arm.joints[i]], accel);
  return limits;
}

MotionLimits finger_limits(const Joint& joint) {
  MotionLimits limits = motion_limits(joint, kFingerAccel);
  limits.max_velocity = kGripperSpeed;
  return limits;
}

MotionLimits head_limits(const Joint& joint) {
  MotionLimits limits = motion_limits(joint, kHeadAccel);
  limits.max_velocity = kHeadSpeed;
  return limits;
}

class BaxterSimulator final : public Simulator {
 public:
  BaxterSimulator(SimulatorParams params, RobotModel robot, WorldSpec world, RobotJoints joints)
      : params_(std::move(params)), robot_(std::move(robot)), world_(std::move(world)), joints_(joints) {}

  Result<void> reset() override {
    auto positions = start_positions(robot_, joints_, params_.arms.start_pose);
    if (!positions) return tl::unexpected(positions.error());
    auto bodies = Bodies::make(params_.bodies, robot_, world_, to_pose(world_.robot_start), *positions);
    if (!bodies) return tl::unexpected(bodies.error());
    parts_.emplace(Parts{std::move(*bodies),
                         MobileBase(params_.base, world_.robot_start, params_.seed),
                         {},
                         {},
                         {},
                         HeadController(head_limits(robot_.joints()[joints_.head_pan])),
                         FaultBook(robot_)});
    for (const auto& person : world_.people) parts_->people.emplace_back(person);
    for (const Side side : kSides) add_arm(side, *positions);
    state_ = RobotState{};
    state_.enabled = params_.start_enabled;
    steps_ = 0;
    measure();
    return {};
  }

  void step() override {
    ++steps_;
    parts_->faults.expire(time_s());
    move_people();
    move_base();
    for (const Side side : kSides) drive_arm(side);
    drive_head();
    parts_->bodies->step();
    measure();
  }

  double time_s() const override { return static_cast<double>(steps_) * params_.bodies.step_s; }
  const SimulatorParams& params() const override { return params_; }
  const RobotModel& robot() const override { return robot_; }
  const WorldSpec& world() const override { return world_; }

  void enable(bool on) override {
    if (!state_.stopped) state_.enabled = on;
  }
  void stop() override {
    state_.enabled = false;
    state_.stopped = true;
    state_.source = RobotState::Stop::kButton;
  }
  void reset_stop() override { state_ = RobotState{}; }

  Result<void> command_arm(Side side, const ArmCommand& command) override {
    for (const auto& value : command.values)
      if (value && !std::isfinite(*value))
        return fail(ErrorCode::kInvalidArgument, "arm command: every value must be a finite number");
    if (command.mode == ArmMode::kTorque && !params_.bodies.dynamic)
      return fail(ErrorCode::kUnsupported,
                  "arm command: torque mode needs dynamic arms: start the simulator with dynamic:=true");
    if (!may_move()) return {};
    arm(side).command(command, time_s());
    return {};
  }
  void set_speed_ratio(Side side, double ratio) override {
    if (std::isfinite(ratio)) arm(side).set_speed_ratio(ratio);
  }
  void set_arm_timeout(Side side, double timeout_s) override {
    if (std::isfinite(timeout_s)) arm(side).set_timeout(timeout_s);
  }
  Result<void> command_gripper(Side side, const GripperCommand& command) override {
    if (!may_move()) return fail(ErrorCode::kFailed, "gripper: the robot is not enabled: enable it first");
    return gripper(side).command(command);
  }
  void command_head_pan(double target_rad, double speed_ratio) override {
    if (may_move()) parts_->head.pan_to(target_rad, speed_ratio);
  }
  void command_head_nod() override {
    if (may_move()) parts_->head.nod(time_s());
  }
  void command_base(const Twist2& velocity) override { parts_->base.command(velocity, time_s()); }

  RobotState robot_state() const override { return state_; }
  GripperState gripper_state(Side side) const override { return parts_->grippers[index(side)].state(); }
  HeadState head_state() const override { return parts_->head.state(); }
  BaseState base_state() const override { return parts_->base.state(); }
  ImuSample imu() const override { return parts_->base.imu(); }

  ArmState arm_state(Side side) const override;
  JointSample joints() const override;
  Snapshot snapshot() const override;

  Result<void> move_body(const std::string& name, const Pose& world_T_body) override {
    if (!world_T_body.matrix().allFinite())
      return fail(ErrorCode::kInvalidArgument, "move_body: every number of the pose must be finite");
    for (std::size_t i = 0; i < world_.bodies.size(); ++i)
      if (world_.bodies[i].name == name) return parts_->bodies->move_body(static_cast<int>(i), world_T_body);
    return fail(ErrorCode::kNotFound, "move_body: world '" + world_.name + "' has no body '" + name + "'");
  }
  void move_robot(const Pose2& pose) override {
    if (!std::isfinite(pose.x) || !std::isfinite(pose.y) || !std::isfinite(pose.yaw)) return;
    parts_->base.place(pose);
    parts_->bodies->set_root(to_pose(pose));
  }

  Result<void> set_fault(const Fault& fault) override { return parts_->faults.set(fault, time_s()); }
  std::vector<Fault> faults() const override { return parts_->faults.active(); }

 private:
  static int index(Side side) { return static_cast<int>(side); }
  ArmController& arm(Side side) { return parts_->arms[index(side)]; }
  GripperController& gripper(Side side) { return parts_->grippers[index(side)]; }
  [[nodiscard]] bool may_move() const { return state_.enabled && !state_.stopped; }

  void add_arm(Side side, const std::vector<double>& positions);
  void move_people();
  void move_base();
  void drive_arm(Side side);
  void drive_gripper(Side side);
  void drive_head();
  void measure();
  [[nodiscard]] ArmMeasurement measurement(Side side) const;

  SimulatorParams params_;
  RobotModel robot_;
  WorldSpec world_;
  RobotJoints joints_;
  std::optional<Parts> parts_;
  RobotState state_;
  std::uint64_t steps_{0};
  std::vector<double> gravity_;  // effort per joint that holds it
};

void BaxterSimulator::add_arm(Side side, const std::vector<double>& positions) {
  const auto& found = joints_.arms[index(side)];
  ArmValues start{};
  for (int i = 0; i < kArmJoints; ++i) start[i] = positions[found.joints[i]];
  parts_->arms.emplace_back(arm_limits(robot_, found, params_.arms.max_accel_rad_s2), start,
                            params_.arms.command_timeout_s);
  const Joint& finger = robot_.joints()[found.finger];
  parts_->grippers.emplace_back(finger_limits(finger), finger.max_effort, positions[found.finger]);
}

void BaxterSimulator::move_people() {
  for (std::size_t i = 0; i < parts_->people.size(); ++i) {
    parts_->people[i].step(params_.bodies.step_s, parts_->base.state().truth);
    parts_->bodies->set_person(static_cast<int>(i), parts_->people[i].pose());
  }
}

void BaxterSimulator::move_base() {
  auto& base = parts_->base;
  for (int i = 0; i < 4; ++i) base.set_slip(i, parts_->faults.wheel_slip(i));
  base.step(time_s(), params_.bodies.step_s,
            [this](const Pose2& pose) { return parts_->bodies->root_collides(to_pose(pose)); });
  parts_->bodies->set_root(to_pose(base.state().truth));
  for (int i = 0; i < 4; ++i)
    parts_->bodies->set_target(joints_.wheels[i], {Drive::kPosition, base.state().wheel_position[i],
                                                   base.state().wheel_velocity[i], 0, 0});
}

ArmMeasurement BaxterSimulator::measurement(Side side) const {
  ArmMeasurement measured;
  for (int i = 0; i < kArmJoints; ++i) {
    const int joint = joints_.arms[index(side)].joints[i];
    measured.position[i] = parts_->bodies->position(joint);
    measured.gravity[i] = gravity_[joint];
  }
  return measured;
}

void BaxterSimulator::drive_arm(Side side) {
  const auto& found = joints_.arms[index(side)];
  for (int i = 0; i < kArmJoints; ++i)
    arm(side).set_stuck(i, parts_->faults.joint_is_stuck(robot_.joints()[found.joints[i]].name));
  const auto targets = arm(side).step(time_s(), params_.bodies.step_s, may_move(), measurement(side));
  for (int i = 0; i < kArmJoints; ++i) parts_->bodies->set_target(found.joints[i], targets[i]);
  drive_gripper(side);
}

void BaxterSimulator::drive_gripper(Side side) {
  const int finger = joints_.arms[index(side)].finger;
  const auto& bodies = *parts_->bodies;
  const GripperMeasurement measured{bodies.position(finger), bodies.gripped(finger).has_value(),
                                    bodies.grip_force(finger)};
  const bool free = may_move() && !parts_->faults.joint_is_stuck(robot_.joints()[finger].name);
  parts_->bodies->set_target(finger, gripper(side).step(params_.bodies.step_s, free, measured));
}

void BaxterSimulator::drive_head() {
  const bool stuck = parts_->faults.joint_is_stuck(robot_.joints()[joints_.head_pan].name);
  const double pan = parts_->head.step(time_s(), params_.bodies.step_s, may_move(), stuck);
  parts_->bodies->set_target(joints_.head_pan, {Drive::kPosition, pan, parts_->head.velocity(), 0, 0});
}

void BaxterSimulator::measure() {
  // Torque mode needs it in every step; otherwise it is computed on request.
  if (params_.bodies.dynamic || gravity_.empty()) gravity_ = parts_->bodies->gravity_efforts();
}

ArmState BaxterSimulator::arm_state(Side side) const {
  const auto& found = joints_.arms[index(side)];
  const auto& bodies = *parts_->bodies;
  const auto gravity = params_.bodies.dynamic ? gravity_ : bodies.gravity_efforts();
  ArmState state;
  Eigen::Matrix<double, kArmJoints, 1> rates;
  Eigen::Matrix<double, kArmJoints, 1> loads;
  for (int i = 0; i < kArmJoints; ++i) {
    const int joint = found.joints[i];
    state.position[i] = bodies.position(joint);
    state.velocity[i] = rates[i] = bodies.velocity(joint);
    state.gravity[i] = gravity[joint];
    state.effort[i] = params_.bodies.dynamic ? bodies.effort(joint) : gravity[joint];
    loads[i] = state.effort[i] - state.gravity[i];
  }
  state.command = parts_->arms[index(side)].set_points();
  std::vector<double> positions(robot_.joints().size());
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = bodies.position(static_cast<int>(i));
  const auto links = robot_.link_poses(positions);
  const ArmJacobian jacobian = arm_jacobian(robot_, joints_, side, links);
  state.base_T_endpoint = links[joints_.base].inverse() * links[found.endpoint];
  state.twist = jacobian * rates;
  // What the arm presses with: the least wrench that explains the efforts beyond gravity.
  state.wrench = jacobian.transpose().completeOrthogonalDecomposition().solve(loads);
  return state;
}

JointSample BaxterSimulator::joints() const {
  JointSample sample;
  const auto& bodies = *parts_->bodies;
  for (std::size_t i = 0; i < robot_.joints().size(); ++i) {
    if (robot_.joints()[i].type == JointType::kFixed) continue;
    const int joint = static_cast<int>(i);
    sample.names.push_back(robot_.joints()[i].name);
    sample.position.push_back(bodies.position(joint));
    sample.velocity.push_back(bodies.velocity(joint));
    sample.effort.push_back(bodies.effort(joint));
  }
  return sample;
}

Snapshot BaxterSimulator::snapshot() const {
  Snapshot taken;
  taken.time_s = time_s();
  taken.world_T_link.reserve(robot_.links().size());
  taken.world_T_body.reserve(world_.bodies.size());
  for (std::size_t i = 0; i < robot_.links().size(); ++i)
    taken.world_T_link.push_back(parts_->bodies->world_T_link(static_cast<int>(i)));
  for (std::size_t i = 0; i < world_.bodies.size(); ++i)
    taken.world_T_body.push_back(parts_->bodies->world_T_body(static_cast<int>(i)));
  for (const auto& person : parts_->people) taken.world_T_person.push_back(person.pose());
  return taken;
}

}  // namespace

Result<std::unique_ptr<Simulator>> Simulator::make(const SimulatorParams& params, RobotModel robot,
                                                   WorldSpec world) {
  if (auto checked = check(params); !checked) return tl::unexpected(checked.error());
  auto joints = find_joints(robot);
  if (!joints) return tl::unexpected(joints.error());
  auto simulator = std::make_unique<BaxterSimulator>(params, std::move(robot), std::move(world), *joints);
  if (auto started = simulator->reset(); !started) return tl::unexpected(started.error());
  return simulator;
}

}  // namespace extperfc::simulate
