#include "ros/robot/joint_state_publisher.hpp"

#include <string>

#include "ros/robot/arm_messages.hpp"

namespace extperfc::ros_robot {

JointStatePublisher::JointStatePublisher(ros::NodeHandle handle, ros_simulate::SimHost& host, double rate_hz)
    : host_(host), ticker_(rate_hz) {
  publisher_ = handle.advertise<sensor_msgs::JointState>("robot/joint_states", 10);
  rate_subscriber_ =
      handle.subscribe("robot/joint_state_publish_rate", 1, &JointStatePublisher::on_rate, this);
}

void JointStatePublisher::after_step(const simulate::Simulator& simulator, const ros::Time& stamp) {
  if (!ticker_.due(stamp.toSec()) || publisher_.getNumSubscribers() == 0) return;
  publisher_.publish(boost::make_shared<sensor_msgs::JointState>(to_message(simulator.joints(), stamp)));
}

void JointStatePublisher::on_rate(const std_msgs::UInt16ConstPtr& message) {
  if (message->data < 1 || message->data > 1000)
    return complaints_.report("robot/joint_state_publish_rate: " + std::to_string(message->data) +
                              " Hz is outside [1, 1000]: the rate stays");
  const double rate_hz = message->data;
  if (!host_.post([this, rate_hz](simulate::Simulator&) { ticker_ = ros_simulate::Ticker(rate_hz); }))
    complaints_.report("robot/joint_state_publish_rate: the simulation accepts no commands now");
}

}  // namespace extperfc::ros_robot
