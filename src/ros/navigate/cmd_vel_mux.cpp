#include <csignal>

#include <ros/callback_queue.h>
#include <ros/ros.h>

#include "ros/navigate/cmd_vel_mux_node.hpp"

/// The program `cmd_vel_mux`: CmdVelMuxNode in a separate process. Exit status 1 on bad
/// parameters.
namespace {

constexpr double kLookS = 0.2;  // between checks for the signal

volatile std::sig_atomic_t stop_asked = 0;

void on_signal(int /*signal*/) {
  stop_asked = 1;
}

int run() {
  auto node = extperfc::ros_navigate::CmdVelMuxNode::make(ros::NodeHandle(), ros::NodeHandle("~"),
                                                          ros::this_node::getName());
  if (!node) {
    ROS_FATAL("%s", node.error().message.c_str());
    return 1;
  }
  while (ros::ok() && stop_asked == 0)
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(kLookS));
  return 0;  // the node stops the base while ROS still runs
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "cmd_vel_mux", ros::init_options::NoSigintHandler);
  (void)std::signal(SIGINT, on_signal);
  (void)std::signal(SIGTERM, on_signal);
  const ros::NodeHandle keep_alive;
  const int code = run();
  ros::shutdown();
  return code;
}
