#include <baxter_core_msgs/EndpointState.h>
#include <baxter_core_msgs/HeadPanCommand.h>
#include <baxter_core_msgs/JointCommand.h>
#include <baxter_core_msgs/SEAJointState.h>
#include <control_msgs/JointControllerState.h>
#include <moveit_msgs/MotionPlanRequest.h>
#include <sensor_msgs/BatteryState.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/Marker.h>

#include "test/translator/puppet_bytes.hpp"

namespace puppet {
namespace {

template <class Message>
void add(Kinds& kinds) {
  MessageKind kind;
  kind.advertise = [](ros::NodeHandle& node, const std::string& topic, bool latch) {
    return node.advertise<Message>(topic, 1000, latch);
  };
  kind.publish = [](const ros::Publisher& publisher, const Bytes& bytes) {
    publisher.publish(from_bytes<Message>(bytes));
  };
  kind.subscribe = [](ros::NodeHandle& node, const std::string& topic) {
    const boost::function<void(const ros::MessageEvent<const Message>&)> hear =
        [topic](const ros::MessageEvent<const Message>& event) {
          report("message " + topic + " " + event.getPublisherName() + " " +
                 to_hex(to_bytes(*event.getMessage())));
        };
    return node.subscribe<Message>(topic, 1000, hear, ros::VoidConstPtr(),
                                   ros::TransportHints().tcpNoDelay());
  };
  kinds.messages[ros::message_traits::DataType<Message>::value()] = kind;
}

}  // namespace

void add_messages(Kinds& kinds) {
  add<baxter_core_msgs::EndpointState>(kinds);
  add<baxter_core_msgs::HeadPanCommand>(kinds);
  add<baxter_core_msgs::JointCommand>(kinds);
  add<baxter_core_msgs::SEAJointState>(kinds);
  add<control_msgs::JointControllerState>(kinds);
  add<moveit_msgs::MotionPlanRequest>(kinds);
  add<sensor_msgs::BatteryState>(kinds);
  add<sensor_msgs::Image>(kinds);
  add<sensor_msgs::JointState>(kinds);
  add<std_msgs::Float64>(kinds);
  add<std_msgs::String>(kinds);
  add<tf2_msgs::TFMessage>(kinds);
  add<visualization_msgs::Marker>(kinds);
}

}  // namespace puppet
