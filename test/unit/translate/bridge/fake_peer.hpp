#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/translate/peer.hpp"

namespace extperfc::translate::test {

inline FramePtr frame_of(const std::vector<std::uint8_t>& bytes) {
  auto frame = std::make_shared<Frame>();
  std::copy(bytes.begin(), bytes.end(), frame->resize_payload(bytes.size()));
  return frame;
}

inline std::vector<std::uint8_t> bytes_of(ByteView view) {
  return {view.data, view.data + view.size};
}

/// What a test wants to know of one subscriber's handshake.
struct Handshake {
  bool accepted{false}, refused{false}, latching{false};
  std::string type, md5, reason;
  LinkId link{0};
};

class FakePublication;

class FakeSubscriberRequest final : public SubscriberRequest {
 public:
  FakeSubscriberRequest(FakePublication& publication, ConnectionHeader header,
                        std::shared_ptr<Handshake> handshake)
      : publication_(publication), header_(std::move(header)), handshake_(std::move(handshake)) {}
  [[nodiscard]] const ConnectionHeader& header() const override { return header_; }
  [[nodiscard]] const std::string& remote_address() const override { return address_; }
  LinkId accept(const std::string& type, const std::string& md5, const std::string& definition,
                bool latching) override;
  void refuse(const std::string& reason) override {
    handshake_->refused = true;
    handshake_->reason = reason;
  }

 private:
  FakePublication& publication_;
  ConnectionHeader header_;
  std::shared_ptr<Handshake> handshake_;
  std::string address_{"127.0.0.1"};
};

struct FakeTopics;

class FakePublication final : public Publication {
 public:
  FakePublication(std::string topic, std::string type, Handlers handlers, SendParams params,
                  FakeTopics& topics);
  ~FakePublication() override;
  [[nodiscard]] const std::string& topic() const override { return topic_; }
  void send(LinkId link, FramePtr frame, SteadyTime) override { sent[link].push_back(std::move(frame)); }
  void close(LinkId link) override { drop(link); }
  void configure(const SendParams& params) override { params_ = params; }
  [[nodiscard]] std::vector<LinkId> links() const override {
    std::vector<LinkId> all;
    for (const auto& [link, frames] : sent) all.push_back(link);
    return all;
  }
  [[nodiscard]] LinkStats stats(LinkId) const override { return {}; }
  void announce_again() override {
    ++announced_again;
    for (const auto link : links()) drop(link);
  }

  /// A subscriber comes.
  std::shared_ptr<Handshake> request(ConnectionHeader header) {
    auto handshake = std::make_shared<Handshake>();
    handlers_.on_request(std::make_shared<FakeSubscriberRequest>(*this, std::move(header), handshake));
    return handshake;
  }
  void drop(LinkId link) {
    if (sent.erase(link) > 0) handlers_.on_down(link, "test");
  }

  std::map<LinkId, std::vector<FramePtr>> sent;
  int announced_again{0};
  std::string type_;
  SendParams params_;
  LinkId next_link_{1};

 private:
  std::string topic_;
  Handlers handlers_;
  FakeTopics& topics_;
};

class FakeSubscription final : public Subscription {
 public:
  FakeSubscription(std::string topic, Handlers handlers, FakeTopics& topics);
  ~FakeSubscription() override;
  [[nodiscard]] const std::string& topic() const override { return topic_; }
  [[nodiscard]] std::size_t connected() const override { return links_.size(); }
  void set_priority(Priority) override {}
  void compare(std::size_t publishers) override { compared = publishers; }
  [[nodiscard]] std::string problem() const override { return trouble; }

  std::size_t compared{0};
  std::string trouble;

  LinkId connect(ConnectionHeader header) {
    PublisherLink link{next_link_++, "http://publisher/", std::move(header)};
    links_[link.id] = link;
    if (!handlers_.on_up(link)) links_.erase(link.id);
    return link.id;
  }
  void message(LinkId link, FramePtr frame) {
    handlers_.on_message(links_.at(link), std::move(frame), EventLoop::now());
  }
  void complain(const std::string& uri, const std::string& reason) { handlers_.on_problem(uri, reason); }
  void gone(LinkId id) {
    const auto link = links_.at(id);
    links_.erase(id);
    handlers_.on_down(link, "test");
    handlers_.on_gone(link);
  }

 private:
  std::string topic_;
  Handlers handlers_;
  FakeTopics& topics_;
  std::map<LinkId, PublisherLink> links_;
  LinkId next_link_{1};
};

/// What lives at a fake peer now.
struct FakeTopics {
  std::map<std::string, FakePublication*> publications;
  std::map<std::string, FakeSubscription*> subscriptions;
};

inline LinkId FakeSubscriberRequest::accept(const std::string& type, const std::string& md5,
                                            const std::string&, bool latching) {
  *handshake_ = {true, false, latching, type, md5, "", publication_.next_link_++};
  publication_.sent[handshake_->link];
  return handshake_->link;
}

inline FakePublication::FakePublication(std::string topic, std::string type, Handlers handlers,
                                        SendParams params, FakeTopics& topics)
    : type_(std::move(type)),
      params_(params),
      topic_(std::move(topic)),
      handlers_(std::move(handlers)),
      topics_(topics) {
  topics_.publications[topic_] = this;
}
inline FakePublication::~FakePublication() {
  topics_.publications.erase(topic_);
}
inline FakeSubscription::FakeSubscription(std::string topic, Handlers handlers, FakeTopics& topics)
    : topic_(std::move(topic)), handlers_(std::move(handlers)), topics_(topics) {
  topics_.subscriptions[topic_] = this;
}
inline FakeSubscription::~FakeSubscription() {
  topics_.subscriptions.erase(topic_);
}

class FakeServiceServer final : public ServiceServer {
 public:
  FakeServiceServer(std::string name, Handlers server_handlers)
      : handlers(std::move(server_handlers)), name_(std::move(name)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  Handlers handlers;

 private:
  std::string name_;
};

/// A server somewhere; answers each call at once.
class FakeServiceLink final : public ServiceLink {
 public:
  using Answer = std::function<Result<FramePtr>(const FramePtr&)>;
  FakeServiceLink(ConnectionHeader header, Answer answer)
      : header_(std::move(header)), answer_(std::move(answer)) {}
  [[nodiscard]] const ConnectionHeader& header() const override { return header_; }
  [[nodiscard]] bool connected() const override { return true; }
  void call(FramePtr request, std::chrono::milliseconds, Done done) override { done(answer_(request)); }

 private:
  ConnectionHeader header_;
  Answer answer_;
};

/// A node without a network: the test plays the other nodes and the master.
class FakePeer final : public Peer {
 public:
  explicit FakePeer(const std::string& name) { params_.name = name; }

  [[nodiscard]] const PeerParams& params() const override { return params_; }
  [[nodiscard]] const std::string& uri() const override { return uri_; }
  [[nodiscard]] const MasterStatus& master() const override { return master_; }
  void graph(std::function<void(Result<GraphState>)> done) override { done(GraphState{}); }

  std::unique_ptr<Publication> advertise(const std::string& topic, const std::string& type,
                                         Publication::Handlers handlers, const SendParams& params) override {
    return std::make_unique<FakePublication>(topic, type, std::move(handlers), params, topics);
  }
  std::unique_ptr<Subscription> subscribe(const std::string& topic, Subscription::Handlers handlers,
                                          const Subscription::Params&) override {
    return std::make_unique<FakeSubscription>(topic, std::move(handlers), topics);
  }
  std::unique_ptr<ServiceServer> serve(const std::string& service,
                                       ServiceServer::Handlers handlers) override {
    auto server = std::make_unique<FakeServiceServer>(service, std::move(handlers));
    served = server.get();
    return server;
  }
  void open_service(const std::string&, const std::string&, bool,
                    std::function<void(Result<std::shared_ptr<ServiceLink>>)> done) override {
    ++services_opened;
    if (!answer) return done(fail(ErrorCode::kNotFound, "no such service"));
    done(std::make_shared<FakeServiceLink>(service_header, answer));
  }

  void get_param(const std::string& name, std::function<void(Result<XmlValue>)> done) override {
    const auto found = param_values.find(name);
    if (found == param_values.end()) return done(fail(ErrorCode::kNotFound, "no such parameter"));
    done(found->second);
  }
  void set_param(const std::string& name, const XmlValue& value,
                 std::function<void(Result<void>)> done) override {
    param_values[name] = value;
    ++writes;
    done({});
    if (echoes && on_param) on_param(name, value);
  }
  void delete_param(const std::string& name, std::function<void(Result<void>)> done) override {
    param_values.erase(name);
    ++writes;
    done({});
    if (echoes && on_param) on_param(name, XmlStruct{});
  }
  void watch_param(const std::string&,
                   std::function<void(const std::string& name, const XmlValue& value)> on_change) override {
    on_param = std::move(on_change);
  }
  void shut_down(std::chrono::milliseconds, std::function<void()> done) override { done(); }

  FakeTopics topics;
  FakeServiceServer* served{nullptr};
  ConnectionHeader service_header;
  FakeServiceLink::Answer answer;
  int services_opened{0};
  std::map<std::string, XmlValue> param_values;
  std::function<void(const std::string&, const XmlValue&)> on_param;
  bool echoes{true};  ///< also notifies the node that made a change, as Indigo's master does
  int writes{0};

 private:
  PeerParams params_;
  std::string uri_{"http://bridge/"};
  MasterStatus master_{true, 1, 0, ""};
};

}  // namespace extperfc::translate::test
