#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "test/unit/translate/peer/raw_socket.hpp"
#include "test/unit/translate/peer/two_peers.hpp"

namespace extperfc::translate::testing {

constexpr const char* kMd5 = "992ce8a1687cec8c8bd883ec73ca41d1";

/// A translator and a plain node, with what a subscription and a publication reported.
class Topics : public TwoPeers {
 protected:
  [[nodiscard]] std::unique_ptr<Peer> make_plain(const std::string& name) {
    auto with = params(name);
    with.marked = false;
    return make(std::move(with));
  }

  [[nodiscard]] std::unique_ptr<Publication> publish(Peer& peer, const std::string& topic,
                                                     SendParams with = {}) {
    Publication::Handlers handlers;
    handlers.on_request = [this](const std::shared_ptr<SubscriberRequest>& request) {
      requests.push_back(request->header());
      const auto id = request->accept("std_msgs/String", kMd5, "string data\n", true);
      if (id != 0 && greet) greet(id);
    };
    handlers.on_down = [this](LinkId, const std::string& reason) { left.push_back(reason); };
    return peer.advertise(topic, "std_msgs/String", handlers, with);
  }

  [[nodiscard]] std::unique_ptr<Subscription> subscribe(Peer& peer, const std::string& topic) {
    Subscription::Handlers handlers;
    handlers.on_up = [this](const PublisherLink& link) {
      ups.push_back(link);
      return wanted;
    };
    handlers.on_message = [this](const PublisherLink&, const FramePtr& frame, SteadyTime received) {
      EXPECT_LE(received, EventLoop::now());
      messages.push_back(text_of(frame));
    };
    handlers.on_down = [this](const PublisherLink&, const std::string& reason) { downs.push_back(reason); };
    handlers.on_gone = [this](const PublisherLink& link) { gone.push_back(link.uri); };
    handlers.on_problem = [this](const std::string&, const std::string& reason) {
      problems.push_back(reason);
    };
    return peer.subscribe(topic, handlers, {});
  }

  void send_all(Publication& publication, const FramePtr& frame) {
    for (const auto id : publication.links()) publication.send(id, frame, EventLoop::now());
  }

  /// Where a node takes connections for a topic.
  [[nodiscard]] std::uint16_t stream_port(const std::string& uri, const std::string& topic) {
    Resolver resolver(loop, {});
    RpcClient client(loop, resolver);
    std::int32_t port = 0;
    bool answered = false;
    client.call(uri, "requestTopic", {"/test", topic, XmlArray{XmlArray{"TCPROS"}}}, kDeadline,
                [&](const Result<XmlValue>& answer) {
                  answered = true;
                  if (!answer) return;
                  const auto& list = *answer->as<XmlArray>();
                  if (*list.at(0).as<std::int32_t>() == 1)
                    port = *list.at(2).as<XmlArray>()->at(2).as<std::int32_t>();
                });
    EXPECT_TRUE(until([&] { return answered; }));
    return static_cast<std::uint16_t>(port);
  }

  std::vector<ConnectionHeader> requests;
  std::function<void(LinkId)> greet;
  bool wanted{true};
  std::vector<PublisherLink> ups;
  std::vector<std::string> messages, left, downs, gone, problems;
};

/// A node that names its listening socket, for any request; what the socket does is the test's matter.
class FakePublisher {
 public:
  explicit FakePublisher(EventLoop& loop) : server_(loop) {
    listening = RawSocket::listen_on_any(port_);
    const auto opened = server_.open("127.0.0.1", 0, [this](const XmlCall&, const std::string&) -> XmlValue {
      ++asked;
      return XmlArray{1, "", XmlArray{"TCPROS", "127.0.0.1", std::int32_t{port_}}};
    });
    if (opened) uri = "http://127.0.0.1:" + std::to_string(*opened) + "/";
  }
  std::string uri;
  RawSocket listening;
  int asked{0};

 private:
  RpcServer server_;
  std::uint16_t port_{0};
};

}  // namespace extperfc::translate::testing
