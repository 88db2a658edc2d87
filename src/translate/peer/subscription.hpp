#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "translate/peer/missing_subscribers.hpp"
#include "translate/peer/peer_core.hpp"
#include "translate/peer/subscription_consumers.hpp"
#include "translate/peer/tcpros_frame_reader.hpp"

namespace extperfc::translate {

/// The publishers of one topic and our connections to them: one each, which all consumers share.
/// Handlers hold it weakly, as PublicationState's do.
class SubscriptionState : public std::enable_shared_from_this<SubscriptionState> {
 public:
  SubscriptionState(std::shared_ptr<PeerCore> core, std::string topic, Subscription::Params params);

  void open();
  /// A further consumer. Connections that stand, and what latching publishers sent last, are reported to it
  /// soon.
  [[nodiscard]] Consumers::ConsumerPtr join(Subscription::Handlers handlers,
                                            const Subscription::Params& params);
  /// With the last consumer the subscription ends.
  void leave(const Consumers::ConsumerPtr& consumer);
  /// The master's list of publishers now. Connections to publishers that only an earlier master knew are kept
  /// until they break: nodes do not register again by themselves.
  void update(const std::vector<std::string>& uris);
  void set_priority(Consumers::Consumer& consumer, Priority priority);
  void compare(std::size_t publishers);

  [[nodiscard]] const std::string& topic() const { return topic_; }
  [[nodiscard]] const std::string& type() const { return params_.type; }
  [[nodiscard]] MasterLink::RegistrationId registration() const { return registration_; }
  [[nodiscard]] const std::string& md5() const { return params_.md5; }
  /// Of publishers whose connections end again and again; empty when there is none.
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] std::vector<BusLink> bus() const;

 private:
  static constexpr unsigned kLooks = 3, kMaxLooks = 64;
  static constexpr std::size_t kFlaps = 3;  ///< lost connections within TcprosParams::flap_window
  enum class Step : std::uint8_t { kAsking, kConnecting, kUp, kWaiting, kRejected, kGone };
  /// One publisher.
  struct Source {
    PublisherLink link;
    Step step{Step::kWaiting};
    bool listed{true};
    std::uint64_t master{0};   ///< which life of the master listed it last
    std::uint64_t attempt{0};  ///< answers to earlier attempts are void
    EventLoop::TimerId retry{0};
    std::chrono::milliseconds delay{0};
    std::unique_ptr<TcprosConnector> connector;
    LoopSocket socket;
    std::unique_ptr<FrameReader> reader;
    SteadyTime up_since;
    std::optional<SteadyTime> down_since;  ///< it was up, and is lost since then
    std::uint64_t messages{0}, bytes{0};
    std::string problem;            ///< the last one reported
    std::deque<SteadyTime> losses;  ///< the latest kFlaps times that the connection was lost
    std::string loss;               ///< why it was lost last
    FramePtr latched;               ///< the last message of a latching publisher, for consumers to come
  };
  using SourcePtr = std::shared_ptr<Source>;

  void close();
  void catch_up(const Consumers::ConsumerPtr& consumer);
  void catch_up(Consumers::Consumer& consumer, const SourcePtr& source);
  void use_priority();
  void reject_unwanted();
  void add_or_retry(const std::string& uri, bool also_rejected);
  void remove(const SourcePtr& source);
  void ask(const SourcePtr& source);
  void answered(const SourcePtr& source, const Result<XmlValue>& answer);
  void connect(const SourcePtr& source, HostPort to);
  void connected_to(const SourcePtr& source, Result<Outgoing> outgoing);
  void bring_up(const SourcePtr& source, Outgoing outgoing);
  void read(SourcePtr source);
  void lose(const SourcePtr& source, const std::string& reason);
  void reject(const SourcePtr& source, const std::string& reason);
  void fail_attempt(const SourcePtr& source, const std::string& reason);
  void retry_later(const SourcePtr& source);
  void stop(Source& source) const;
  void report_problem(Source& source, const std::string& reason);
  void note_loss(const SourcePtr& source, const std::string& reason);
  [[nodiscard]] bool flaps(const Source& source) const;

  std::shared_ptr<PeerCore> core_;
  std::string topic_;
  Consumers consumers_;
  Subscription::Params params_;  ///< the priority is that of the most urgent consumer
  MasterLink::RegistrationId registration_{0};
  std::map<std::string, SourcePtr> sources_;  ///< by URI
  std::set<std::string> listed_;
  unsigned unequal_looks_{0}, patience_{kLooks};  ///< of compare()
  /// Publishers by URI. The master's word that one was replaced is lost when it comes while the network is
  /// away, so it is asked again.
  MissingSubscribers missing_publishers_;
  bool closed_{false};
};

/// URIs in a list of publishers; what is no string is left out.
[[nodiscard]] std::vector<std::string> uris_in(const XmlValue& value);

/// Joins a subscription of that topic and MD5 when there is one.
[[nodiscard]] std::unique_ptr<Subscription> make_subscription(const std::shared_ptr<PeerCore>& core,
                                                              const std::string& topic,
                                                              Subscription::Handlers handlers,
                                                              const Subscription::Params& params);

}  // namespace extperfc::translate
