#include "ros/mapping/pose_publisher.hpp"

#include <utility>

#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <std_msgs/Float64.h>

#include "ros/convert/planar_pose.hpp"

namespace extperfc::ros_mapping {

PosePublisher::PosePublisher(ros::NodeHandle handle, ros::NodeHandle private_handle, std::string map_frame)
    : map_frame_(std::move(map_frame)),
      pose_(handle.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 20)),
      particles_(handle.advertise<geometry_msgs::PoseArray>("particlecloud", 2)),
      entropy_(private_handle.advertise<std_msgs::Float64>("entropy", 2)) {}

void PosePublisher::publish(const mapping::MapperUpdate& update, const ros::Time& stamp,
                            SharedMapper& mapper) const {
  std_msgs::Header header;
  header.frame_id = map_frame_;
  header.stamp = stamp;
  publish_pose(update, header);
  if (update.status != mapping::ScanStatus::kKeyFrame) return;
  if (particles_.getNumSubscribers() > 0) publish_particles(header, mapper);
  if (entropy_.getNumSubscribers() > 0) {
    std_msgs::Float64 message;
    message.data = mapper.with([](const mapping::Mapper& m) { return m.statistics().entropy; });
    entropy_.publish(message);
  }
}

void PosePublisher::publish_pose(const mapping::MapperUpdate& update, const std_msgs::Header& header) const {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = header;
  message.pose.pose = ros_convert::to_pose_message(update.pose);
  message.pose.covariance = ros_convert::to_covariance_message(update.covariance);
  pose_.publish(message);
}

void PosePublisher::publish_particles(const std_msgs::Header& header, SharedMapper& mapper) const {
  const auto particles = mapper.with([](const mapping::Mapper& m) { return m.particles(); });
  geometry_msgs::PoseArray message;
  message.header = header;
  message.poses.reserve(particles.size());
  for (const auto& particle : particles) message.poses.push_back(ros_convert::to_pose_message(particle.pose));
  particles_.publish(message);
}

}  // namespace extperfc::ros_mapping
