#pragma once

#include <ros/console.h>
#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

namespace extperfc::ros_program {

/// ros::init with SIGINT and SIGTERM left to spin_until_signal(), so that a node ends while ROS still runs.
void init(int argc, char** argv, const char* name);

/// Serves callbacks until a signal comes or ROS ends.
void spin_until_signal();

/// A node in a process of its own: `Node::make(handle, private handle, name)` gives a Result. Exit status 1
/// when it refuses to start.
template <typename Node>
int run_node(int argc, char** argv, const char* name) {
  init(argc, argv, name);
  const ros::NodeHandle keep_alive;
  int code = 0;
  {
    auto node = Node::make(ros::NodeHandle(), ros::NodeHandle("~"), ros::this_node::getName());
    if (node) {
      spin_until_signal();
    } else {
      ROS_FATAL("%s", node.error().message.c_str());
      code = 1;
    }
  }
  ros::shutdown();
  return code;
}

}  // namespace extperfc::ros_program
