#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <control_msgs/JointJog.h>
#include <geometry_msgs/TwistStamped.h>
#include <ros/node_handle.h>

#include "extperfc/arm/jogger.hpp"
#include "extperfc/arm/motion_pipeline.hpp"

#include "ros/arm/arms_lease.hpp"
#include "ros/arm/plan_execution.hpp"

namespace extperfc::ros_arm {

/// Moves one arm by velocity commands and keeps it free of collisions. The first command preempts any other
/// motion of the arms; the lease ends with the commands.
///
/// Subscribes:
///   arm/<gripper>/jog_joints  control_msgs/JointJog: velocities [rad/s]; displacements are ignored
///   arm/<gripper>/jog_twist   geometry_msgs/TwistStamped: of the tip, along the present axes of frame_id
///                             (empty: the tip)
/// Publishes:
///   robot/limb/<side>/joint_command  baxter_core_msgs/JointCommand, velocities, while it moves
///   arm/<gripper>/jog_status         std_msgs/String, when it changes: moving, or why the arm is held back
class JogServer {
 public:
  JogServer(ros::NodeHandle handle, const Shared& shared, ArmsLease& lease,
            const std::atomic<std::uint64_t>& stops, const ros_params::GripperParams& gripper);
  ~JogServer();
  JogServer(const JogServer&) = delete;
  JogServer& operator=(const JogServer&) = delete;

 private:
  struct Session;

  void on_joints(const control_msgs::JointJogConstPtr& message);
  void on_twist(const geometry_msgs::TwistStampedConstPtr& message);
  void accept(const arm::JogCommand& command);
  void work();
  void jog(const ArmsLease::Hold& hold);
  bool refresh(Session& session, const arm::JointPositions& positions);
  void publish(const arm::JogStep& step, const arm::JointVector& measured);
  [[nodiscard]] static std::string describe(const arm::JogStep& step);
  void report_status(const std::string& status);

  const Shared shared_;
  ArmsLease& lease_;
  const std::atomic<std::uint64_t>& stops_;
  const ros_params::GripperParams gripper_;
  const arm::ArmGroup& group_;
  arm::MotionPipeline pipeline_;  ///< of the worker
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<arm::JogCommand> command_;
  std::uint64_t commands_{0};
  bool closing_{false};
  std::string status_;
  ros::Publisher command_publisher_;
  ros::Publisher status_publisher_;
  ros::Subscriber joints_subscriber_;
  ros::Subscriber twist_subscriber_;
  std::thread worker_;
};

}  // namespace extperfc::ros_arm
