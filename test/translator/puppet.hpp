#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <ros/node_handle.h>

/// A ROS node on strings: typed publishers, subscribers, services and actions, commanded by lines on standard
/// input, reporting by lines on standard output. Protocol: puppet.py.
namespace puppet {

using Bytes = std::vector<std::uint8_t>;

/// "x" and two hexadecimal digits a byte.
std::string to_hex(const Bytes& bytes);
/// Throws std::invalid_argument.
Bytes from_hex(const std::string& text);
/// Writes a line, whole, from any thread.
void report(const std::string& line);

/// What is typed in a message, seen without its type.
struct MessageKind {
  std::function<ros::Publisher(ros::NodeHandle&, const std::string& topic, bool latch)> advertise;
  std::function<void(const ros::Publisher&, const Bytes&)> publish;
  std::function<ros::Subscriber(ros::NodeHandle&, const std::string& topic)> subscribe;
};

struct ServiceKind {
  /// An empty pointer as the response: the server refuses.
  std::function<ros::ServiceServer(ros::NodeHandle&, const std::string& name,
                                   std::shared_ptr<Bytes> response)>
      serve;
  std::function<bool(ros::NodeHandle&, const std::string& name, const Bytes& request, Bytes& response)> call;
};

class ActionServer {
 public:
  virtual ~ActionServer() = default;
  virtual void feedback(const Bytes& feedback) = 0;
  virtual void finish(const std::string& how, const Bytes& result, const std::string& text) = 0;
};

class ActionClient {
 public:
  virtual ~ActionClient() = default;
  virtual bool wait_for_server(double seconds) = 0;
  virtual void send_goal(const Bytes& goal) = 0;
  virtual void cancel() = 0;
};

struct ActionKind {
  std::function<std::unique_ptr<ActionServer>(ros::NodeHandle&, const std::string& name)> serve;
  std::function<std::unique_ptr<ActionClient>(const std::string& name)> connect;
};

struct Kinds {
  std::map<std::string, MessageKind> messages;
  std::map<std::string, ServiceKind> services;
  std::map<std::string, ActionKind> actions;
};

void add_messages(Kinds& kinds);
void add_services(Kinds& kinds);
void add_actions(Kinds& kinds);

}  // namespace puppet
