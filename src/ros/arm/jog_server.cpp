#include "ros/arm/jog_server.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <baxter_core_msgs/JointCommand.h>
#include <std_msgs/String.h>

namespace extperfc::ros_arm {

using arm::JogCommand;
using arm::JointVector;

namespace {

constexpr double kOtherMoved = 0.005;  ///< of another joint of the robot: the checker is rebuilt [rad]
constexpr double kCorrection = 4.0;    ///< velocity per deviation from the wanted position [1/s]

double now_s() {
  return ros::SteadyTime::now().toSec();
}

}  // namespace

/// From the first command to the last.
struct JogServer::Session {
  std::unique_ptr<arm::CollisionChecker> checker;
  std::optional<arm::Jogger> jogger;
  std::uint64_t scene{0};
  arm::JointPositions checked_at;
};

JogServer::JogServer(ros::NodeHandle handle, const Shared& shared, ArmsLease& lease,
                     const std::atomic<std::uint64_t>& stops, const ros_params::GripperParams& gripper)
    : shared_(shared),
      lease_(lease),
      stops_(stops),
      gripper_(gripper),
      group_(**shared_.arms.group(gripper_.group)),
      pipeline_(shared_.arms, shared_.params.pipeline) {
  const std::string own = "arm/" + gripper_.name + "/";
  command_publisher_ =
      handle.advertise<baxter_core_msgs::JointCommand>("robot/limb/" + gripper_.name + "/joint_command", 1);
  status_publisher_ = handle.advertise<std_msgs::String>(own + "jog_status", 1, true);
  worker_ = std::thread([this] { work(); });
  joints_subscriber_ = handle.subscribe(own + "jog_joints", 1, &JogServer::on_joints, this);
  twist_subscriber_ = handle.subscribe(own + "jog_twist", 1, &JogServer::on_twist, this);
}

JogServer::~JogServer() {
  joints_subscriber_.shutdown();
  twist_subscriber_.shutdown();
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  worker_.join();
}

void JogServer::on_joints(const control_msgs::JointJogConstPtr& message) {
  JogCommand command;
  command.kind = JogCommand::Kind::kJoints;
  command.joint_velocity = JointVector::Zero(static_cast<Eigen::Index>(group_.joints.size()));
  if (message->joint_names.size() != message->velocities.size())
    return report_status("bad_input: jog_joints needs a velocity for each of its joints");
  for (std::size_t i = 0; i < message->joint_names.size(); ++i) {
    const auto found = std::find(group_.joints.begin(), group_.joints.end(), message->joint_names[i]);
    if (found == group_.joints.end())
      return report_status("bad_input: " + message->joint_names[i] + " is not a joint of " + group_.name);
    command.joint_velocity[found - group_.joints.begin()] = message->velocities[i];
  }
  accept(command);
}

void JogServer::on_twist(const geometry_msgs::TwistStampedConstPtr& message) {
  JogCommand command;
  const auto& linear = message->twist.linear;
  const auto& angular = message->twist.angular;
  command.twist << linear.x, linear.y, linear.z, angular.x, angular.y, angular.z;
  const auto& frame = message->header.frame_id;
  command.kind = JogCommand::Kind::kTwistTip;
  if (!frame.empty() && frame != gripper_.tip) {
    const auto root_T_frame = shared_.transforms.root_T_frame(frame, ros::Time());
    if (!root_T_frame) return report_status("bad_input: " + root_T_frame.error().message);
    command.kind = JogCommand::Kind::kTwistRoot;
    command.twist.head<3>() = root_T_frame->linear() * command.twist.head<3>().eval();
    command.twist.tail<3>() = root_T_frame->linear() * command.twist.tail<3>().eval();
  }
  accept(command);
}

void JogServer::accept(const JogCommand& command) {
  const std::lock_guard lock(mutex_);
  command_ = command;
  command_->stamp_s = now_s();
  ++commands_;
  changed_.notify_all();
}

void JogServer::work() {
  std::uint64_t done = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return closing_ || commands_ != done; });
      if (closing_) return;
    }
    const auto hold = lease_.take();
    if (!hold.superseded()) jog(hold);
    const std::lock_guard lock(mutex_);
    done = commands_;
  }
}

/// Updates the jogger's world; false on an error, which is reported.
bool JogServer::refresh(Session& session, const arm::JointPositions& positions) {
  const auto moved = [&](const auto& joint) {
    const auto now = positions.find(joint.first);
    const bool ours =
        std::find(group_.joints.begin(), group_.joints.end(), joint.first) != group_.joints.end();
    return !ours && now != positions.end() && std::abs(now->second - joint.second) > kOtherMoved;
  };
  const auto version = shared_.scene.version();
  if (session.jogger && session.scene == version &&
      std::none_of(session.checked_at.begin(), session.checked_at.end(), moved))
    return true;
  const auto world = shared_.scene.world();
  if (!world) return report_status("bad_input: " + world.error().message), false;
  auto made = pipeline_.checker(group_.name, positions, *world, true);
  if (!made) return report_status("bad_input: " + made.error().message), false;
  auto checker = std::make_unique<arm::CollisionChecker>(std::move(*made));
  if (session.jogger) {
    session.jogger->use(*checker);
  } else {
    const auto chain = arm::ArmChain::make(shared_.arms.robot(), shared_.arms.root_link(), gripper_.tip);
    if (!chain) return report_status("bad_input: " + chain.error().message), false;
    arm::JoggerParams params;
    params.command_timeout_s = shared_.params.jog.command_timeout_s;
    params.max_velocity = shared_.params.jog.velocity_scale * group_.max_velocity;
    auto jogger = arm::Jogger::make(*checker, *chain, params);
    if (!jogger) return report_status("bad_input: " + jogger.error().message), false;
    session.jogger.emplace(std::move(*jogger));
  }
  session.checker = std::move(checker);
  session.scene = version;
  session.checked_at = positions;
  return true;
}

void JogServer::jog(const ArmsLease::Hold& hold) {
  Session session;
  const auto stops = stops_.load();
  const double period = 1.0 / shared_.params.jog.rate_hz;
  std::uint64_t seen = 0;
  double next = now_s();
  for (;;) {
    if (const auto not_ready = shared_.robot_state.not_ready_reason())
      return report_status("stopped: " + not_ready->message);
    const auto positions = shared_.robot_state.positions();
    if (!positions) return report_status("stopped: " + positions.error().message);
    const auto measured = arm::RobotArms::select(group_, *positions);
    if (!measured) return report_status("stopped: " + measured.error().message);
    if (!refresh(session, *positions)) return;
    {
      const std::lock_guard lock(mutex_);
      if (closing_) return;
      if (seen != commands_ && command_) session.jogger->command(*command_);
      seen = commands_;
    }
    if (hold.superseded() || stops != stops_) session.jogger->command({});  // brakes
    const auto step = session.jogger->step(now_s(), *measured, period);
    if (step.positions.size() > 0) publish(step, *measured);
    report_status(step.moving && step.hindrance == arm::JogHindrance::kNone ? "moving" : describe(step));
    const bool ended = step.hindrance == arm::JogHindrance::kTimeout || hold.superseded() || stops != stops_;
    if (!step.moving && ended) return report_status("idle");
    next = std::max(next + period, now_s());
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(next - now_s()), [&] { return closing_; });
  }
}

std::string JogServer::describe(const arm::JogStep& step) {
  std::string text = to_string(step.hindrance);
  if (!step.joint.empty()) text += ": " + step.joint;
  if (step.contact) text += ": " + step.contact->first + ", " + step.contact->second;
  return (step.moving ? "slow, " : "held, ") + text;
}

void JogServer::publish(const arm::JogStep& step, const JointVector& measured) {
  baxter_core_msgs::JointCommand message;
  message.mode = baxter_core_msgs::JointCommand::VELOCITY_MODE;
  message.names = group_.joints;
  const JointVector velocity = step.velocities + kCorrection * (step.positions - measured);
  message.command.assign(velocity.begin(), velocity.end());
  command_publisher_.publish(message);
}

void JogServer::report_status(const std::string& status) {
  {
    const std::lock_guard lock(mutex_);
    if (status == status_) return;
    status_ = status;
  }
  std_msgs::String message;
  message.data = status;
  status_publisher_.publish(message);
}

}  // namespace extperfc::ros_arm
