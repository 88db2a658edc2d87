#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/translate/peer.hpp"

#include "translate/peer/carrier_monitor.hpp"
#include "translate/peer/master_link.hpp"
#include "translate/peer/tcpros_half_open.hpp"
#include "translate/peer/tcpros_handshake.hpp"

namespace extperfc::translate {

class PublicationState;
class SubscriptionState;
class ServiceServerState;

/// One row of getBusInfo. Source: http://wiki.ros.org/ROS/Slave_API.
struct BusLink {
  LinkId id{0};
  std::string other;  ///< caller id of a subscriber, or URI of a publisher
  bool outbound{false};
  std::string topic;
  LinkStats stats;
};

/// What the parts of one node share. Lives until the last of them is gone; of the loop's thread.
class PeerCore : public std::enable_shared_from_this<PeerCore> {
 public:
  PeerCore(EventLoop& loop, FramePool& frames, PeerParams params, Peer::Handlers handlers);

  /// Opens both ports and passes our URI to the master link.
  [[nodiscard]] Result<void> open();
  void close();

  [[nodiscard]] LinkId next_link() { return ++last_link_; }
  /// At most some lines in some seconds; the number of suppressed lines is reported afterwards.
  void log(const std::string& line);
  /// What each header of ours holds: caller id and mark.
  [[nodiscard]] ConnectionHeader own_header() const;
  /// Another translator's mark, as far as it matters to us; "" when there is none.
  [[nodiscard]] std::string mark_in(const ConnectionHeader& header) const;

  EventLoop& loop;
  FramePool& frames;
  PeerParams params;
  Peer::Handlers handlers;
  std::string host;  ///< as advertised
  std::string uri;
  std::uint16_t tcpros_port{0};
  ByteBuffer scratch;
  Resolver resolver;
  RpcClient client;
  RpcServer server;
  TcprosListener listener;
  HalfOpenNotices half_open;
  CarrierMonitor carrier;
  std::unique_ptr<MasterLink> master;
  bool closed{false};

  /// What strangers and the master may ask for, by name; the latest of one name comes first.
  std::multimap<std::string, PublicationState*> publications;
  std::multimap<std::string, SubscriptionState*> subscriptions;
  std::multimap<std::string, ServiceServerState*> services;
  struct ParamWatch {
    std::string prefix;
    std::function<void(const std::string& name, const XmlValue& value)> on_change;
  };
  std::vector<std::shared_ptr<ParamWatch>> param_watches;

 private:
  [[nodiscard]] Result<void> find_host();
  void dispatch(Incoming incoming);
  void lose_carrier(const std::vector<std::string>& addresses);
  void open_log_window();

  LinkId last_link_{0};
  int lines_left_;
  std::uint64_t lines_dropped_{0};
  bool log_window_open_{false};
};

/// Answers of our slave API.
[[nodiscard]] XmlValue answer_slave_call(PeerCore& core, const XmlCall& call, const std::string& from);

/// Ends a registration, and what the master and strangers may ask for under that name.
template <typename State>
void end_registration(PeerCore& core, std::multimap<std::string, State*>& all, const std::string& name,
                      State* self) {
  core.master->drop(self->registration());
  for (auto at = all.find(name); at != all.end() && at->first == name;) {
    at = at->second == self ? all.erase(at) : std::next(at);
  }
}

/// The newest object of that name, or null.
template <typename State>
[[nodiscard]] State* newest(const std::multimap<std::string, State*>& all, const std::string& name) {
  const auto range = all.equal_range(name);
  return range.first == range.second ? nullptr : std::prev(range.second)->second;
}

}  // namespace extperfc::translate
