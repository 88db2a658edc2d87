#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Int32.h>
#include <std_msgs/String.h>

#include "extperfc/base/error.hpp"
#include "extperfc/navigate/velocity_mux.hpp"

#include "ros/health/reporter.hpp"
#include "ros/params/cmd_vel_mux_params.hpp"

namespace extperfc::ros_navigate {

/// Gives the base to one of several sources of velocity commands: the emergency stop, else the source of
/// largest priority that is not silent. Commands are limited. Also a program: rosrun extperfc cmd_vel_mux.
///
/// Subscribes:
///   <topic>   geometry_msgs/Twist, one for each of the parameter `sources`
///   <stop_topic>  std_msgs/Bool: true stops the base until false comes
///   ~lock     std_msgs/Int32: sources below this priority have no effect; 0: no lock
/// Publishes:
///   cmd_vel      geometry_msgs/Twist, while a source is active; zero once when the last falls silent, and
///                all the time while stopped
///   ~active      std_msgs/String, latched: name of the source that has the base; "stop", or empty
///   diagnostics  diagnostic_msgs/DiagnosticArray
/// Parameters: config/cmd_vel_mux.yaml.
/// Diagnostics: the active source, refused commands; WARN while stopped.
/// Threads: callbacks and a timer of wall time, one at a time.
class CmdVelMuxNode {
 public:
  /// Errors: every bad parameter at once.
  [[nodiscard]] static Result<std::unique_ptr<CmdVelMuxNode>> make(const ros::NodeHandle& handle,
                                                                   const ros::NodeHandle& private_handle,
                                                                   const std::string& name);
  /// Sends zero if a source has the base.
  ~CmdVelMuxNode();
  CmdVelMuxNode(const CmdVelMuxNode&) = delete;
  CmdVelMuxNode& operator=(const CmdVelMuxNode&) = delete;

 private:
  CmdVelMuxNode(const ros::NodeHandle& handle, ros::NodeHandle private_handle,
                const ros_params::CmdVelMuxParams& params, navigate::VelocityMux mux,
                const std::string& name);
  void on_command(std::size_t source, const geometry_msgs::Twist& message);
  void on_stop(const std_msgs::Bool& message);
  void on_lock(const std_msgs::Int32& message);
  void send();
  void publish_active(const std::string& name);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  std::mutex mutex_;
  navigate::VelocityMux mux_;
  std::string active_;
  std::uint64_t refused_{0};
  ros::Publisher velocity_publisher_;
  ros::Publisher active_publisher_;
  ros_health::Reporter reporter_;
  std::vector<ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
};

}  // namespace extperfc::ros_navigate
