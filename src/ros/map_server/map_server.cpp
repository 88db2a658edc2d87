#include <string>

#include <ros/ros.h>

#include "ros/map_server/map_server_node.hpp"

/// The program `map_server`: MapServerNode in a separate process. Exit status 1 on bad parameters or maps, 2
/// on bad arguments.
int main(int argc, char** argv) {
  ros::init(argc, argv, "map_server");
  if (argc > 2) {
    ROS_FATAL("usage: map_server [MAP.yaml]: the YAML file of a map, else the parameters map_file or floors");
    return 2;
  }
  const std::string map_file = argc == 2 ? argv[1] : "";
  auto node = extperfc::ros_map_server::MapServerNode::make(ros::NodeHandle(), ros::NodeHandle("~"),
                                                            ros::this_node::getName(), map_file);
  if (!node) {
    ROS_FATAL("%s", node.error().message.c_str());
    return 1;
  }
  ros::spin();
  return 0;
}
