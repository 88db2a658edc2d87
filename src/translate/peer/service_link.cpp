#include "translate/peer/service_link.hpp"

#include <deque>
#include <utility>

#include <sys/epoll.h>

#include "translate/peer/tcpros_frame_reader.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kMaxCalls = 1000;

/// The connection and the calls that wait; one is under way at a time.
class LinkState : public std::enable_shared_from_this<LinkState> {
 public:
  LinkState(std::shared_ptr<PeerCore> core, std::string service, ConnectionHeader header)
      : core_(std::move(core)),
        service_(std::move(service)),
        header_(std::move(header)),
        reader_(core_->frames, core_->scratch, {core_->params.tcpros.message_bytes, true, true}) {}

  void open(LoopSocket socket);
  void call(FramePtr request, std::chrono::milliseconds timeout, ServiceLink::Done done);
  void forget();
  [[nodiscard]] const ConnectionHeader& header() const { return header_; }
  [[nodiscard]] bool connected() const { return static_cast<bool>(socket_); }

 private:
  struct Call {
    std::uint64_t id{0};
    FramePtr request;
    ServiceLink::Done done;
    EventLoop::TimerId timer{0};
  };

  void fail_later(ServiceLink::Done done, const std::string& reason);
  void send_next();
  void sent(BytesWriter::Outcome outcome);
  void handle(std::uint32_t events);
  void read();
  void finish(std::shared_ptr<Frame> response, bool ok);
  void time_out(std::uint64_t id);
  void lose(const std::string& reason);

  std::shared_ptr<PeerCore> core_;
  std::string service_;
  ConnectionHeader header_;
  LoopSocket socket_;
  FrameReader reader_;
  BytesWriter writer_;
  std::deque<Call> calls_;
  bool request_sent_{false};  ///< the first call's request was given to the socket
  std::uint64_t last_call_{0};
};

Error call_error(const std::string& service, const std::string& reason) {
  return {ErrorCode::kFailed, "service " + service + ": " + reason};
}

void LinkState::open(LoopSocket socket) {
  socket_ = std::move(socket);
  socket_.watch(core_->loop, EPOLLIN | EPOLLRDHUP, Priority::kControl,
                [weak = weak_from_this()](std::uint32_t events) {
                  if (const auto self = weak.lock()) self->handle(events);
                });
}

void LinkState::fail_later(ServiceLink::Done done, const std::string& reason) {
  core_->loop.post(
      [done = std::move(done), error = call_error(service_, reason)] { done(tl::unexpected<Error>(error)); });
}

void LinkState::call(FramePtr request, std::chrono::milliseconds timeout, ServiceLink::Done done) {
  if (!socket_) return fail_later(std::move(done), "the connection is closed");
  if (calls_.size() >= kMaxCalls) return fail_later(std::move(done), "too many calls wait for it");
  const auto id = ++last_call_;
  const auto timer = core_->loop.after(timeout, [weak = weak_from_this(), id] {
    if (const auto self = weak.lock()) self->time_out(id);
  });
  calls_.push_back({id, std::move(request), std::move(done), timer});
  if (!request_sent_) send_next();
}

void LinkState::send_next() {
  if (calls_.empty() || !socket_) return;
  request_sent_ = true;
  sent(writer_.write(socket_.get(), calls_.front().request->wire(), {}));
}

void LinkState::sent(BytesWriter::Outcome outcome) {
  if (outcome == BytesWriter::Outcome::kBroken) {
    core_->loop.post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->lose("the server closed the connection");
    });
    return;
  }
  const bool blocked = outcome == BytesWriter::Outcome::kBlocked;
  socket_.want(blocked ? EPOLLIN | EPOLLRDHUP | EPOLLOUT : EPOLLIN | EPOLLRDHUP);
}

void LinkState::handle(std::uint32_t events) {
  if ((events & EPOLLOUT) != 0) sent(writer_.flush(socket_.get()));
  if ((events & ~std::uint32_t{EPOLLOUT}) != 0) read();
}

void LinkState::read() {
  const auto outcome = reader_.read(socket_.get(), core_->params.tcpros.read_at_once,
                                    [this](std::shared_ptr<Frame> response, std::uint8_t status, SteadyTime) {
                                      finish(std::move(response), status != 0);
                                      return static_cast<bool>(socket_);
                                    });
  if (outcome == FrameReader::Outcome::kClosed || outcome == FrameReader::Outcome::kBroken) {
    lose(reader_.problem());
  }
}

void LinkState::finish(std::shared_ptr<Frame> response, bool ok) {
  if (calls_.empty() || !request_sent_) return lose("unexpected response from the server");
  auto call = std::move(calls_.front());
  calls_.pop_front();
  request_sent_ = false;
  core_->loop.cancel(call.timer);
  send_next();
  if (ok) return call.done(FramePtr(std::move(response)));
  constexpr std::size_t kMaxText = 4096;
  const auto text = response->payload();
  call.done(tl::unexpected<Error>(call_error(
      service_, "the server failed: " +
                    std::string(reinterpret_cast<const char*>(text.data), std::min(text.size, kMaxText)))));
}

void LinkState::time_out(std::uint64_t id) {
  for (auto& call : calls_) {
    if (call.id == id) call.timer = 0;
  }
  lose("no answer in time");
}

void LinkState::lose(const std::string& reason) {
  socket_.close();
  request_sent_ = false;
  const auto calls = std::exchange(calls_, {});
  for (const auto& call : calls) core_->loop.cancel(call.timer);
  for (const auto& call : calls) call.done(tl::unexpected<Error>(call_error(service_, reason)));
}

void LinkState::forget() {
  socket_.close();
  for (const auto& call : calls_) core_->loop.cancel(call.timer);
  calls_.clear();
}

class LinkHandle : public ServiceLink {
 public:
  explicit LinkHandle(std::shared_ptr<LinkState> state) : state_(std::move(state)) {}
  ~LinkHandle() override { state_->forget(); }
  LinkHandle(const LinkHandle&) = delete;
  LinkHandle& operator=(const LinkHandle&) = delete;

  const ConnectionHeader& header() const override { return state_->header(); }
  bool connected() const override { return state_->connected(); }
  void call(FramePtr request, std::chrono::milliseconds timeout, Done done) override {
    state_->call(std::move(request), timeout, std::move(done));
  }

 private:
  std::shared_ptr<LinkState> state_;
};

/// One attempt to open a link; keeps itself until it ended.
class Opener : public std::enable_shared_from_this<Opener> {
 public:
  using Done = std::function<void(Result<std::shared_ptr<ServiceLink>>)>;
  Opener(std::shared_ptr<PeerCore> core, std::string service, bool probe, Done done)
      : core_(std::move(core)), service_(std::move(service)), probe_(probe), done_(std::move(done)) {}

  void start(const std::string& md5) {
    core_->master->call(
        "lookupService", {service_}, [self = shared_from_this(), md5](const Result<XmlValue>& uri) {
          if (!uri) return self->end(tl::unexpected<Error>(Error{ErrorCode::kNotFound, uri.error().message}));
          const auto* text = uri->as<std::string>();
          const auto to = text != nullptr ? parse_uri(*text)
                                          : fail(ErrorCode::kCorrupt, "the master does not know its URI");
          if (!to) return self->end(tl::unexpected<Error>(call_error(self->service_, to.error().message)));
          self->connect(*to, md5);
        });
  }

 private:
  void connect(const HostPort& to, const std::string& md5) {
    if (core_->closed) return;
    auto header = core_->own_header();
    header["service"] = service_;
    header["md5sum"] = md5;
    header[probe_ ? "probe" : "persistent"] = "1";
    TcprosConnector::Params params{to, std::move(header), core_->params.node_timeout, Priority::kControl,
                                   core_->params.tcpros};
    connector_ = std::make_unique<TcprosConnector>(
        core_->loop, core_->resolver, std::move(params),
        [self = shared_from_this()](Result<Outgoing> outgoing) { self->connected(std::move(outgoing)); });
  }

  void connected(Result<Outgoing> outgoing) {
    if (!outgoing) return end(tl::unexpected<Error>(call_error(service_, outgoing.error().message)));
    const auto refused = outgoing->header.find("error");
    if (refused != outgoing->header.end()) {
      return end(tl::unexpected<Error>(call_error(service_, "refused: " + refused->second)));
    }
    auto state = std::make_shared<LinkState>(core_, service_, std::move(outgoing->header));
    if (!probe_) state->open(std::move(outgoing->socket));
    end(std::shared_ptr<ServiceLink>(std::make_shared<LinkHandle>(std::move(state))));
  }

  void end(Result<std::shared_ptr<ServiceLink>> result) {
    connector_.reset();
    const auto done = std::exchange(done_, nullptr);
    if (done && !core_->closed) done(std::move(result));
  }

  std::shared_ptr<PeerCore> core_;
  std::string service_;
  bool probe_;
  Done done_;
  std::unique_ptr<TcprosConnector> connector_;
};

}  // namespace

void open_service_link(const std::shared_ptr<PeerCore>& core, const std::string& service,
                       const std::string& md5, bool probe,
                       std::function<void(Result<std::shared_ptr<ServiceLink>>)> done) {
  std::make_shared<Opener>(core, service, probe, std::move(done))->start(md5);
}

}  // namespace extperfc::translate
