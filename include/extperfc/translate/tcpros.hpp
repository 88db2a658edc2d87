#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/frame.hpp"

/// TCPROS: connection headers, and the streams of topics and services.
/// Source: http://wiki.ros.org/ROS/Connection%20Header, http://wiki.ros.org/ROS/TCPROS.
namespace extperfc::translate {

/// Keys and values of a connection header: topic, type, md5sum, callerid, message_definition, ...
using ConnectionHeader = std::map<std::string, std::string>;
/// With its length in front, ready to send.
[[nodiscard]] ByteBuffer encode_header(const ConnectionHeader& header);
/// Without the length in front. An error names what is wrong: a length beyond the end, no '=', too many
/// fields.
[[nodiscard]] Result<ConnectionHeader> decode_header(ByteView bytes);
[[nodiscard]] std::string value_of(const ConnectionHeader& header,
                                   const std::string& key);  ///< "" when missing

/// The translator's mark in connection headers: marked connections are not translated again, so that
/// translators between the same masters cannot form a loop. Its value is the translator's name.
inline constexpr const char* kTranslatorKey = "extperfc_translator";

/// Limits and timeouts of connections.
struct TcprosParams {
  std::size_t header_bytes{1U << 20U};               ///< maximum size of a connection header
  std::size_t message_bytes{256U << 20U};            ///< a longer message ends its connection
  std::size_t links{512};                            ///< connections at once of one port or topic
  std::chrono::milliseconds handshake{5'000};        ///< from the connection to the end of its headers
  std::chrono::milliseconds unacknowledged{10'000};  ///< TCP_USER_TIMEOUT: a connection whose data is not
                                                     ///< acknowledged for this time is closed
  std::chrono::milliseconds keep_alive{5'000};       ///< silence before a TCP keep-alive probe
  std::chrono::milliseconds retry_first{100};        ///< after a lost connection; doubles
  std::chrono::milliseconds retry_last{5'000};
  std::chrono::milliseconds call_back_first{1'000};  ///< after a broken connection, until the master is asked
                                                     ///< to name publishers again; doubles
  std::chrono::milliseconds call_back_last{30'000};
  /// A publisher that was connected and cannot be reached any more is a problem after this time.
  std::chrono::milliseconds lost_grace{5'000};
  /// A publisher whose connection is lost several times within this time is a problem: messages are lost.
  std::chrono::milliseconds flap_window{30'000};
  std::size_t read_at_once{256U << 10U};  ///< bytes read from one connection before the next is served
};

/// How one topic's messages are sent.
struct SendParams {
  std::size_t queue{10};                ///< maximum messages per subscriber; the oldest is dropped; 0 means 1
  std::size_t queue_bytes{64U << 20U};  ///< maximum size of the queue (one message is always allowed)
  std::chrono::milliseconds max_age{0};                     ///< older messages are dropped; 0: no limit
  std::optional<std::chrono::milliseconds> unacknowledged;  ///< instead of TcprosParams'
  Priority priority{Priority::kNormal};
};

using LinkId = std::uint64_t;

struct LinkStats {
  std::uint64_t messages{0}, bytes{0};
  std::uint64_t dropped_queue{0};  ///< the queue was full
  std::uint64_t dropped_age{0};    ///< waited longer than max_age
  std::size_t waiting{0};          ///< in the queue now
};

/// A subscriber's connection that waits for our header. Answer once, now or later; one that is let go
/// unanswered is refused, and one that waits longer than TcprosParams::handshake is closed.
class SubscriberRequest {
 public:
  virtual ~SubscriberRequest() = default;
  [[nodiscard]] virtual const ConnectionHeader& header()
      const = 0;  ///< callerid, topic, type, md5sum ("*" is any)
  [[nodiscard]] virtual const std::string& remote_address() const = 0;
  /// Sends our header (callerid, topic, latching and our mark are added). 0 when the subscriber left
  /// meanwhile.
  virtual LinkId accept(const std::string& type, const std::string& md5, const std::string& definition,
                        bool latching) = 0;
  virtual void refuse(const std::string& reason) = 0;  ///< as an `error` header, then closes
};

/// A topic that we publish: one connection for each subscriber.
class Publication {
 public:
  struct Handlers {
    std::function<void(std::shared_ptr<SubscriberRequest>)> on_request;
    /// A link ended, other than by close() or the destructor. Never inside a call of this class; stats() of
    /// the link are still there.
    std::function<void(LinkId, const std::string& reason)> on_down;
  };
  virtual ~Publication() = default;  ///< unregisters and closes
  [[nodiscard]] virtual const std::string& topic() const = 0;
  /// Queues a message for one subscriber; `since` is when it came in, for max_age. Unknown links are ignored.
  virtual void send(LinkId link, FramePtr frame, SteadyTime since) = 0;
  virtual void close(LinkId link) = 0;
  virtual void configure(const SendParams& params) = 0;
  [[nodiscard]] virtual std::vector<LinkId> links() const = 0;
  [[nodiscard]] virtual LinkStats stats(LinkId link) const = 0;
  /// Unregisters and registers at the master again and drops all links, so that subscribers that gave up
  /// (roscpp after a header error) come back.
  virtual void announce_again() = 0;
};

/// A connection to one publisher of a topic that we subscribe to.
struct PublisherLink {
  LinkId id{0};
  std::string uri;  ///< of the publisher's node
  ConnectionHeader
      header;  ///< as the publisher sent it: callerid, type, md5sum, message_definition, latching
};

/// A topic that we subscribe to: one connection to each publisher, retried after a loss for as long as the
/// master lists the publisher. Our own node and publishers that carry our mark are left out. Subscriptions of
/// one peer with the same topic and MD5 share their connections: rospy closes the older one of two
/// connections of one caller id. Each has its own view: another may accept what one refuses; a late one
/// receives the last messages of latching publishers.
class Subscription {
 public:
  struct Handlers {
    /// After the handshake, before messages. False closes it for good (until the publisher registers again).
    std::function<bool(const PublisherLink&)> on_up;
    std::function<void(const PublisherLink&, FramePtr, SteadyTime received)> on_message;
    std::function<void(const PublisherLink&, const std::string& reason)> on_down;
    /// The master no longer lists this publisher; after on_down.
    std::function<void(const PublisherLink&)> on_gone;
    /// A publisher refused us or cannot be reached; once for each new reason.
    std::function<void(const std::string& uri, const std::string& reason)> on_problem;
  };
  struct Params {
    std::string type{"*"};
    std::string md5{"*"};
    bool tcp_nodelay{true};
    Priority priority{Priority::kNormal};
  };
  virtual ~Subscription() = default;  ///< unregisters and closes
  [[nodiscard]] virtual const std::string& topic() const = 0;
  [[nodiscard]] virtual std::size_t connected() const = 0;
  virtual void set_priority(Priority priority) = 0;
  /// Call after each poll of the master's graph with the number of publishers that it lists, without our own.
  /// If the number stays different from the known one, a notification was lost, and the master is asked
  /// again.
  virtual void compare(std::size_t publishers) = 0;
  /// Why messages are lost now: a publisher's connection ends again and again. Empty when all is well.
  [[nodiscard]] virtual std::string problem() const = 0;
};

/// A client's connection to a service of ours. Requests of one connection are answered in order, one at a
/// time.
class ServiceRequest {
 public:
  virtual ~ServiceRequest() = default;
  [[nodiscard]] virtual const ConnectionHeader& header()
      const = 0;  ///< callerid, service, md5sum, probe, persistent
  [[nodiscard]] virtual bool probe() const = 0;
  /// What the request's connection brings: unique while it lasts.
  [[nodiscard]] virtual LinkId link() const = 0;
  virtual void accept(const std::string& type, const std::string& md5, const std::string& request_type,
                      const std::string& response_type) = 0;
  virtual void refuse(const std::string& reason) = 0;
};

class ServiceServer {
 public:
  /// Ends a call: true with the serialized response, or false with a text for the caller's log.
  using Reply = std::function<void(bool ok, ByteView response)>;
  struct Handlers {
    std::function<void(std::shared_ptr<ServiceRequest>)> on_request;  ///< a new connection
    std::function<void(LinkId, FramePtr request, Reply)> on_call;     ///< after accept(), never for probes
    std::function<void(LinkId)> on_down;  ///< of an accepted client; never inside a call or a reply
  };
  virtual ~ServiceServer() = default;  ///< unregisters; calls under way end with an error for their callers
  [[nodiscard]] virtual const std::string& name() const = 0;
};

/// A connection to another node's service, kept open (persistent) for calls one after another.
class ServiceLink {
 public:
  using Done = std::function<void(Result<FramePtr> response)>;  ///< an error carries the server's text
  virtual ~ServiceLink() = default;                             ///< closes; calls that wait are forgotten
  [[nodiscard]] virtual const ConnectionHeader& header() const = 0;  ///< as the server sent it
  [[nodiscard]] virtual bool connected() const = 0;
  /// `done` runs once: the response, the server's refusal, a lost connection, or the timeout (which closes).
  virtual void call(FramePtr request, std::chrono::milliseconds timeout, Done done) = 0;
};

}  // namespace extperfc::translate
