#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/peer.hpp"
#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {

/// One master: whether it lives, what we are registered with there, and its calls. Registrations are kept:
/// they are made when the master can be reached, and made again after it restarted (another pid) or came
/// back. Of the loop's thread. Source: http://wiki.ros.org/ROS/Master_API, ROS/Parameter Server API.
class MasterLink {
 public:
  struct Params {
    std::string master_uri;
    std::string caller_id;
    std::string caller_api;  ///< our slave API's URI
    std::chrono::milliseconds period{1'000};
    std::chrono::milliseconds timeout{3'000};
  };
  struct Handlers {
    std::function<void(const Peer::MasterStatus&)> on_master;
    std::function<void(const std::string& line)> on_log;
  };
  using RegistrationId = std::uint64_t;
  /// The third element of [code, status, value]; code 1 only: else an error with the status text.
  using Done = std::function<void(Result<XmlValue> value)>;

  MasterLink(EventLoop& loop, RpcClient& client, Params params, Handlers handlers);
  ~MasterLink();

  [[nodiscard]] const Peer::MasterStatus& status() const;

  /// Registers, now or when the master comes, and again whenever that is needed. `done` runs after each
  /// success, e.g. with the publishers' URIs of registerSubscriber.
  RegistrationId keep_publisher(const std::string& topic, const std::string& type, Done done);
  RegistrationId keep_subscriber(const std::string& topic, const std::string& type, Done done);
  RegistrationId keep_service(const std::string& service, const std::string& service_uri, Done done);
  RegistrationId keep_param_watch(const std::string& prefix, Done done);
  void drop(RegistrationId registration);   ///< unregisters, best effort
  void again(RegistrationId registration);  ///< unregisters and registers
  /// Registers once more without unregistering: for a publisher the master then notifies every subscriber of
  /// its publishers again, for a subscriber it answers with them. One try; nothing for what is not registered
  /// yet.
  void renew(RegistrationId registration);

  /// A method of the master with our caller id as its first argument.
  void call(const std::string& method, XmlArray further_arguments, Done done);
  void graph(std::function<void(Result<GraphState>)> done);

  /// Unregisters everything; `done` once, after the answers or `patience`.
  void shut_down(std::chrono::milliseconds patience, std::function<void()> done);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace extperfc::translate
