#pragma once

#include <optional>
#include <string>

#include <actionlib/server/action_server.h>
#include <control_msgs/GripperCommandAction.h>
#include <ros/node_handle.h>

#include "ros/simulate/sim_host.hpp"
#include "ros/simulate/ticker.hpp"

namespace extperfc::ros_robot {

struct GripperActionParams {
  double tolerance_percent{5};  ///< of the opening: this near is there
  double timeout_s{5};          ///< of simulated time
  double feedback_rate_hz{100};
};

/// A gripper's action as Baxter's gripper action server has it. A gripper that is not calibrated is
/// calibrated first. Succeeds when the opening is reached or an object is held between the fingers (stalled);
/// aborts when neither happens in time. A newer goal replaces an older one, a cancelled goal stops the
/// fingers.
///
/// Actions:
///   robot/end_effector/<side>_gripper/gripper_action  control_msgs/GripperCommand: position is the opening
///                                                     in per cent (0 closed, 100 open), max_effort the force
///                                                     in per cent; 0 or less leaves the force as it is
///                                                     configured
class GripperAction {
 public:
  GripperAction(const ros::NodeHandle& handle, ros_simulate::SimHost& host, simulate::Side side,
                const GripperActionParams& params);

  void after_step(const simulate::Simulator& simulator, const ros::Time& stamp);

 private:
  using Server = actionlib::ActionServer<control_msgs::GripperCommandAction>;
  using Goal = Server::GoalHandle;

  void on_goal(const Goal& goal);
  void on_cancel(const Goal& goal);
  void begin(Goal goal, simulate::Simulator& simulator);
  void cancel(Goal goal, simulate::Simulator& simulator);
  void go_when_calibrated(const simulate::Simulator& simulator);
  [[nodiscard]] control_msgs::GripperCommandResult result(const simulate::Simulator& simulator,
                                                          const Goal& goal) const;
  void judge(const control_msgs::GripperCommandResult& now, const simulate::Simulator& simulator,
             double time_s);

  ros_simulate::SimHost& host_;
  const simulate::Side side_;
  const GripperActionParams params_;
  ros_simulate::Ticker ticker_;
  std::optional<Goal> active_;                       ///< of the simulation thread, like what follows
  std::optional<simulate::GripperCommand> waiting_;  ///< for the end of a calibration
  std::optional<double> begun_s_;                    ///< stamp of the first step after the last command
  Server server_;                                    // last: no callback comes after the rest is gone
};

}  // namespace extperfc::ros_robot
