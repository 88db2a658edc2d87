#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "translate/peer/missing_subscribers.hpp"
#include "translate/peer/peer_core.hpp"
#include "translate/peer/tcpros_send_queue.hpp"
#include "translate/peer/tcpros_stall.hpp"

namespace extperfc::translate {

/// A publication's links. Handlers of sockets and timers hold it weakly, so its owner may let it go at any
/// time, in its own callbacks too.
class PublicationState : public std::enable_shared_from_this<PublicationState> {
 public:
  PublicationState(std::shared_ptr<PeerCore> core, std::string topic, Publication::Handlers handlers,
                   const SendParams& params);

  void open(const std::string& type);
  void close();
  void incoming(Incoming incoming);  ///< a subscriber's connection with its header

  void send(LinkId id, FramePtr frame, SteadyTime since);
  void close_link(LinkId id);
  void configure(const SendParams& params);
  void announce_again();
  /// The interface with these addresses is down: links of messages with an age limit are given up at once.
  void lose_carrier(const std::vector<std::string>& addresses);

  [[nodiscard]] LinkId accept(LinkId id, ConnectionHeader header);
  void refuse(LinkId id, const std::string& reason);

  [[nodiscard]] const std::string& topic() const { return topic_; }
  [[nodiscard]] const std::string& type() const { return type_; }
  [[nodiscard]] MasterLink::RegistrationId registration() const { return registration_; }
  [[nodiscard]] std::vector<LinkId> links() const;
  [[nodiscard]] LinkStats stats(LinkId id) const;
  [[nodiscard]] std::vector<BusLink> bus() const;

 private:
  struct Pending {
    LoopSocket socket;
    std::string caller;
    EventLoop::TimerId deadline{0};
  };
  struct Link {
    explicit Link(EventLoop& loop, std::function<void()> on_stall)
        : stall(
              loop, [this] { return queue.bytes_written(); }, std::move(on_stall)) {}
    LoopSocket socket;
    ConnectionEnds ends;
    std::string caller;
    SendQueue queue;
    bool blocked{false};  ///< waits until the socket takes more
    bool dead{false};     ///< on_down follows
    StallWatch stall;
  };

  void watch_pending(LinkId id, Pending& pending);
  void forget_pending(LinkId id);
  void watch_link(LinkId id, Link& link);
  void handle(LinkId id, std::uint32_t events);
  void flush(LinkId id, Link& link);
  /// Closes now, reports later: on_down never runs inside a call of the owner.
  void end_link(LinkId id, const std::string& reason);
  /// It ended by a fault: the subscriber is expected back.
  void break_link(LinkId id, const std::string& reason);
  /// The subscriber does not respond: its queue is dropped, and it is notified when it can be reached again.
  void give_up(LinkId id, const std::string& reason);
  /// Its subscriber did not ask for the end.
  void expect(const Link& link);
  /// The master is to name us to our subscribers anew.
  void call_back();
  /// The master's list of subscribers: only nodes on it are expected back.
  void on_registered(const Result<XmlValue>& subscribers);
  void ask_whether_listed(const std::string& caller, const std::vector<std::string>& listed);
  void report_down(LinkId id, const std::string& reason);
  void apply(Link& link) const;
  /// Messages must not arrive late: what the kernel holds is watched from the first byte on.
  [[nodiscard]] bool ages() const { return params_.unacknowledged.has_value(); }
  [[nodiscard]] std::chrono::milliseconds patience() const;

  std::shared_ptr<PeerCore> core_;
  std::string topic_;
  std::string type_;  ///< as registered
  Publication::Handlers handlers_;
  SendParams params_;
  MasterLink::RegistrationId registration_{0};
  std::map<LinkId, Pending> pending_;
  std::map<LinkId, std::unique_ptr<Link>> links_;
  MissingSubscribers missing_subscribers_;  ///< subscribers by caller id
  bool calling_back_{false};                ///< the next registration is that of call_back()
  bool closed_{false};
};

[[nodiscard]] std::unique_ptr<Publication> make_publication(const std::shared_ptr<PeerCore>& core,
                                                            const std::string& topic, const std::string& type,
                                                            Publication::Handlers handlers,
                                                            const SendParams& params);

}  // namespace extperfc::translate
