#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"
#include "extperfc/translate/rpc.hpp"
#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate {

/// Settings of the translator's node at one master.
struct PeerParams {
  std::string name;             ///< name of the node, e.g. "/translator": its only caller id
  std::string master_uri;       ///< "http://baxter.local:11311"
  std::string advertised_host;  ///< name or address by which this side reaches us; empty: the address that
                                ///< the system uses towards the master
  std::string bind_address{"0.0.0.0"};
  std::map<std::string, std::string> hosts;  ///< names to addresses that the system does not resolve
  /// What errors advise: for a name without an address, and when our own address is not known.
  std::string hosts_remedy{"add it to /etc/hosts"};
  std::string advertised_host_remedy{"set the advertised host"};
  std::chrono::milliseconds master_period{1'000};   ///< period of the check that the master is alive
  std::chrono::milliseconds master_timeout{3'000};  ///< of a call to it
  std::chrono::milliseconds node_timeout{5'000};    ///< of a call to another node
  TcprosParams tcpros;
  RpcLimits rpc;
  /// Mark connections as translated, and reject connections with another translator's mark. False makes a
  /// plain node for tests and measurements, like those of roscpp and rospy.
  bool marked{true};
};

/// The master's view of the graph. Nodes are named by caller id.
struct GraphState {
  struct Topic {
    std::string type;  ///< "*" or "" when the master does not know
    std::vector<std::string> publishers, subscribers;
  };
  std::map<std::string, Topic> topics;
  std::map<std::string, std::vector<std::string>> services;  ///< name -> providers
};

/// The translator's node at one master: client of the master, slave API, topics and services, all on one
/// event loop. Several live in one process. Registrations are kept: after the master restarted (another pid)
/// or came back, everything is registered again. Of the loop's thread.
class Peer {
 public:
  struct MasterStatus {
    bool reachable{false};
    std::int32_t pid{0};
    std::uint64_t restarts{0};
    std::string problem;  ///< why it is not reachable
  };
  struct Handlers {
    std::function<void(const MasterStatus&)>
        on_master;  ///< after each change: reachable, unreachable, restarted
    std::function<void(const std::string& line)>
        on_log;  ///< information for the user; rate-limited by the peer
    /// The master or a node asks this one to end: `rosnode kill`, or another node took its name.
    std::function<void()> on_shutdown;
  };

  /// Opens ports. The master need not be there yet.
  [[nodiscard]] static Result<std::unique_ptr<Peer>> make(EventLoop& loop, FramePool& frames,
                                                          PeerParams params, Handlers handlers);
  virtual ~Peer() = default;

  [[nodiscard]] virtual const PeerParams& params() const = 0;
  [[nodiscard]] virtual const std::string& uri() const = 0;  ///< of our slave API, as advertised
  [[nodiscard]] virtual const MasterStatus& master() const = 0;

  /// getSystemState and getTopicTypes.
  virtual void graph(std::function<void(Result<GraphState>)> done) = 0;

  [[nodiscard]] virtual std::unique_ptr<Publication> advertise(const std::string& topic,
                                                               const std::string& type,
                                                               Publication::Handlers handlers,
                                                               const SendParams& params) = 0;
  [[nodiscard]] virtual std::unique_ptr<Subscription> subscribe(const std::string& topic,
                                                                Subscription::Handlers handlers,
                                                                const Subscription::Params& params) = 0;
  [[nodiscard]] virtual std::unique_ptr<ServiceServer> serve(const std::string& service,
                                                             ServiceServer::Handlers handlers) = 0;
  /// Looks a service up and shakes hands; with md5 "*" the handshake returns its type and MD5. `probe` closes
  /// at once after. A dead provider is an error after PeerParams::node_timeout.
  virtual void open_service(const std::string& service, const std::string& md5, bool probe,
                            std::function<void(Result<std::shared_ptr<ServiceLink>>)> done) = 0;

  /// Parameters; names are absolute. Missing ones are kNotFound.
  virtual void get_param(const std::string& name, std::function<void(Result<XmlValue>)> done) = 0;
  virtual void set_param(const std::string& name, const XmlValue& value,
                         std::function<void(Result<void>)> done) = 0;
  virtual void delete_param(const std::string& name, std::function<void(Result<void>)> done) = 0;
  /// `on_change` runs with the whole value now (an empty struct when there is none), and with the changed
  /// name and value at each paramUpdate; subscribed again when the master restarts.
  virtual void watch_param(const std::string& prefix,
                           std::function<void(const std::string& name, const XmlValue& value)> on_change) = 0;

  /// Unregisters everything; `done` after the master's answers or `patience`.
  virtual void shut_down(std::chrono::milliseconds patience, std::function<void()> done) = 0;
};

}  // namespace extperfc::translate
