#pragma once

#include <string>

#include <ros/node_handle.h>

#include "ros/mapping/shared_mapper.hpp"

namespace extperfc::ros_mapping {

/// Publishes the results of one scan: pose, and after key frames particlecloud and ~entropy. Worker thread.
class PosePublisher {
 public:
  PosePublisher(ros::NodeHandle handle, ros::NodeHandle private_handle, std::string map_frame);

  void publish(const mapping::MapperUpdate& update, const ros::Time& stamp, SharedMapper& mapper) const;

 private:
  void publish_pose(const mapping::MapperUpdate& update, const std_msgs::Header& header) const;
  void publish_particles(const std_msgs::Header& header, SharedMapper& mapper) const;

  const std::string map_frame_;
  ros::Publisher pose_;
  ros::Publisher particles_;
  ros::Publisher entropy_;
};

}  // namespace extperfc::ros_mapping
