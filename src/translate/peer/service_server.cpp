#include "translate/peer/service_server.hpp"

#include <utility>

#include <sys/epoll.h>

namespace extperfc::translate {
namespace {

/// [ok, length]: before a response, or before the text of a failure.
std::array<std::uint8_t, 5> response_head(bool ok, std::size_t size) {
  std::array<std::uint8_t, 5> head{};
  head[0] = ok ? 1 : 0;
  for (unsigned i = 0; i < 4; ++i) head[1 + i] = static_cast<std::uint8_t>(size >> (8U * i));
  return head;
}

ByteView bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The owner's answer to one call: counts once; let go without an answer it is a failure.
class ReplyOnce {
 public:
  ReplyOnce(std::weak_ptr<ServiceServerState> server, LinkId link, std::uint64_t call)
      : server_(std::move(server)), link_(link), call_(call) {}
  ~ReplyOnce() { answer(false, bytes_of("the service gave no answer")); }
  ReplyOnce(const ReplyOnce&) = delete;
  ReplyOnce& operator=(const ReplyOnce&) = delete;

  void answer(bool ok, ByteView response) {
    if (const auto server = std::exchange(server_, {}).lock()) server->reply(link_, call_, ok, response);
  }

 private:
  std::weak_ptr<ServiceServerState> server_;
  LinkId link_;
  std::uint64_t call_;
};

class ServerRequest : public ServiceRequest {
 public:
  ServerRequest(std::weak_ptr<ServiceServerState> server, LinkId link, ConnectionHeader header)
      : server_(std::move(server)), link_(link), header_(std::move(header)) {}
  ~ServerRequest() override { ServerRequest::refuse("the service is not available"); }
  ServerRequest(const ServerRequest&) = delete;
  ServerRequest& operator=(const ServerRequest&) = delete;

  const ConnectionHeader& header() const override { return header_; }
  bool probe() const override { return value_of(header_, "probe") == "1"; }
  LinkId link() const override { return link_; }
  void accept(const std::string& type, const std::string& md5, const std::string& request_type,
              const std::string& response_type) override {
    if (const auto server = std::exchange(server_, {}).lock()) {
      server->accept(link_, type, md5, request_type, response_type);
    }
  }
  void refuse(const std::string& reason) override {
    if (const auto server = std::exchange(server_, {}).lock()) server->refuse(link_, reason);
  }

 private:
  std::weak_ptr<ServiceServerState> server_;
  LinkId link_;
  ConnectionHeader header_;
};

}  // namespace

ServiceServerState::ServiceServerState(std::shared_ptr<PeerCore> core, std::string name,
                                       ServiceServer::Handlers handlers)
    : core_(std::move(core)), name_(std::move(name)), handlers_(std::move(handlers)) {}

void ServiceServerState::open() {
  core_->services.emplace(name_, this);
  const auto uri = "rosrpc://" + core_->host + ":" + std::to_string(core_->tcpros_port);
  registration_ = core_->master->keep_service(name_, uri, [](const Result<XmlValue>&) {});
}

void ServiceServerState::close() {
  if (std::exchange(closed_, true)) return;
  end_registration(*core_, core_->services, name_, this);
  const std::string reason = name_ + " shuts down";
  for (auto& [id, client] : clients_) {
    core_->loop.cancel(client->deadline);
    if (client->step == Step::kPending) send_refusal(client->socket.get(), core_->own_header(), reason);
    if (client->step != Step::kCalling) continue;
    const auto head = response_head(false, reason.size());
    (void)client->writer.write(client->socket.get(), {head.data(), head.size()}, bytes_of(reason));
  }
  clients_.clear();
}

void ServiceServerState::incoming(Incoming incoming) {
  const auto refuse_now = [&](const std::string& reason) {
    send_refusal(incoming.socket.get(), core_->own_header(), reason);
  };
  const auto mark = core_->mark_in(incoming.header);
  if (!mark.empty()) {
    return refuse_now(name_ + " is translated by " + core_->params.name +
                      " and is not available to another translator (" + mark + "), to prevent a loop");
  }
  if (clients_.size() >= core_->params.tcpros.links) return refuse_now("too many clients of " + name_);
  if (!handlers_.on_request) return refuse_now(name_ + " takes no clients");
  const auto id = core_->next_link();
  const auto weak = weak_from_this();
  const auto client = std::make_shared<Client>(core_->loop, [weak, id] {
    if (const auto self = weak.lock()) self->end(id);
  });
  client->socket = std::move(incoming.socket);
  client->probe = value_of(incoming.header, "probe") == "1";
  client->persistent = value_of(incoming.header, "persistent") == "1";
  client->deadline = core_->loop.after(core_->params.tcpros.handshake, [weak, id] {
    if (const auto self = weak.lock()) self->refuse(id, "no answer in time");
  });
  clients_.emplace(id, client);
  watch(id, *client);
  const auto keep = shared_from_this();
  handlers_.on_request(std::make_shared<ServerRequest>(weak, id, std::move(incoming.header)));
}

void ServiceServerState::watch(LinkId id, Client& client) {
  client.socket.watch(core_->loop, EPOLLRDHUP, Priority::kControl,
                      [weak = weak_from_this(), id](std::uint32_t events) {
                        if (const auto self = weak.lock()) self->handle(id, events);
                      });
}

void ServiceServerState::refuse(LinkId id, const std::string& reason) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || found->second->accepted) return;
  send_refusal(found->second->socket.get(), core_->own_header(), reason);
  end(id);
}

void ServiceServerState::accept(LinkId id, const std::string& type, const std::string& md5,
                                const std::string& request_type, const std::string& response_type) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || found->second->accepted || closed_) return;
  const auto client = found->second;
  core_->loop.cancel(std::exchange(client->deadline, 0));
  client->accepted = true;
  client->reader = std::make_unique<FrameReader>(
      core_->frames, core_->scratch, FrameReader::Params{core_->params.tcpros.message_bytes, false, true});
  auto header = core_->own_header();
  header.insert({{"service", name_},
                 {"type", type},
                 {"md5sum", md5},
                 {"request_type", request_type},
                 {"response_type", response_type}});
  const auto bytes = encode_header(header);
  client->step = Step::kWriting;
  write(id, *client, bytes.view(), {});
}

void ServiceServerState::handle(LinkId id, std::uint32_t events) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  const auto client = found->second;
  if ((events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0) return end(id);
  if (client->step == Step::kWriting) return written(id, *client, client->writer.flush(client->socket.get()));
  if (client->step == Step::kIdle) read(id, client);
}

void ServiceServerState::read(LinkId id, const ClientPtr& client) {
  const auto outcome = client->reader->read(client->socket.get(), core_->params.tcpros.read_at_once,
                                            [&](std::shared_ptr<Frame> request, std::uint8_t, SteadyTime) {
                                              start_call(id, *client, std::move(request));
                                              return client->step == Step::kIdle;
                                            });
  if (outcome == FrameReader::Outcome::kBroken)
    core_->log("a client of " + name_ + " is closed: " + client->reader->problem());
  if (outcome == FrameReader::Outcome::kBroken || outcome == FrameReader::Outcome::kClosed) end(id);
}

void ServiceServerState::start_call(LinkId id, Client& client, std::shared_ptr<Frame> request) {
  client.step = Step::kCalling;
  client.socket.want(EPOLLRDHUP);
  const auto once = std::make_shared<ReplyOnce>(weak_from_this(), id, ++client.call);
  if (!handlers_.on_call) return;
  handlers_.on_call(id, std::move(request),
                    [once](bool ok, ByteView response) { once->answer(ok, response); });
}

void ServiceServerState::reply(LinkId id, std::uint64_t call, bool ok, ByteView response) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || closed_) return;
  const auto client = found->second;
  if (client->step != Step::kCalling || client->call != call) return;
  client->step = Step::kWriting;
  const auto head = response_head(ok, response.size);
  write(id, *client, {head.data(), head.size()}, response);
}

void ServiceServerState::write(LinkId id, Client& client, ByteView head, ByteView body) {
  written(id, client, client.writer.write(client.socket.get(), head, body));
}

void ServiceServerState::written(LinkId id, Client& client, BytesWriter::Outcome outcome) {
  if (outcome == BytesWriter::Outcome::kBlocked) {
    client.socket.want(EPOLLRDHUP | EPOLLOUT);
    return client.stall.start(client.socket.get(), core_->params.tcpros.unacknowledged);
  }
  client.stall.stop();
  const bool last = client.probe || (client.call > 0 && !client.persistent);
  if (outcome == BytesWriter::Outcome::kBroken || last) return end(id);
  client.step = Step::kIdle;
  client.socket.want(EPOLLRDHUP | EPOLLIN);
}

void ServiceServerState::end(LinkId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  const auto client = found->second;
  core_->loop.cancel(client->deadline);
  client->stall.stop();
  client->socket.close();
  client->step = Step::kPending;
  clients_.erase(found);
  if (!client->accepted || !handlers_.on_down) return;
  // Later: on_down never runs inside a call of the owner, such as its reply.
  core_->loop.post([weak = weak_from_this(), id] {
    const auto self = weak.lock();
    if (self && !self->closed_) self->handlers_.on_down(id);
  });
}

namespace {

class ServiceServerHandle : public ServiceServer {
 public:
  explicit ServiceServerHandle(std::shared_ptr<ServiceServerState> state) : state_(std::move(state)) {}
  ~ServiceServerHandle() override { state_->close(); }
  ServiceServerHandle(const ServiceServerHandle&) = delete;
  ServiceServerHandle& operator=(const ServiceServerHandle&) = delete;
  const std::string& name() const override { return state_->name(); }

 private:
  std::shared_ptr<ServiceServerState> state_;
};

}  // namespace

std::unique_ptr<ServiceServer> make_service_server(const std::shared_ptr<PeerCore>& core,
                                                   const std::string& name,
                                                   ServiceServer::Handlers handlers) {
  auto state = std::make_shared<ServiceServerState>(core, name, std::move(handlers));
  state->open();
  return std::make_unique<ServiceServerHandle>(std::move(state));
}

}  // namespace extperfc::translate
