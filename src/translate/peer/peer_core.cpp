#include "translate/peer/peer_core.hpp"

#include <array>
#include <memory>
#include <utility>

#include <netdb.h>
#include <unistd.h>

#include "translate/peer/publication.hpp"
#include "translate/peer/service_server.hpp"
#include "translate/peer/subscription.hpp"
#include "translate/peer/tcpros_frame_reader.hpp"

namespace extperfc::translate {
namespace {

constexpr int kLinesAtOnce = 20;
constexpr std::chrono::seconds kLogWindow{10};

/// Asks the system; blocks, so only while a node is made.
std::string system_address(const std::string& host) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (::getaddrinfo(host.c_str(), nullptr, &hints, &list) != 0 || list == nullptr) return {};
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owned(list, ::freeaddrinfo);
  std::array<char, NI_MAXHOST> text{};
  if (::getnameinfo(list->ai_addr, list->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST) !=
      0) {
    return {};
  }
  return text.data();
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

std::string in_uri(const std::string& host) {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

}  // namespace

PeerCore::PeerCore(EventLoop& a_loop, FramePool& a_frames, PeerParams a_params, Peer::Handlers a_handlers)
    : loop(a_loop),
      frames(a_frames),
      params(std::move(a_params)),
      handlers(std::move(a_handlers)),
      resolver(loop, params.hosts, params.hosts_remedy),
      client(loop, resolver, params.rpc),
      server(loop, params.rpc),
      listener(loop, params.tcpros, own_header(),
               [this](Incoming incoming) { dispatch(std::move(incoming)); }),
      half_open(loop),
      carrier(loop, [this](const std::vector<std::string>& addresses) { lose_carrier(addresses); }),
      lines_left_(kLinesAtOnce) {
  scratch.resize(FrameReader::kScratch);
}

Result<void> PeerCore::find_host() {
  if (!params.advertised_host.empty()) {
    host = in_uri(params.advertised_host);
    return {};
  }
  const auto master_at = parse_uri(params.master_uri);
  if (!master_at) return tl::unexpected<Error>(master_at.error());
  const auto known = params.hosts.find(master_at->host);
  const auto address = known != params.hosts.end() ? known->second : system_address(master_at->host);
  const auto local = address.empty() ? fail(ErrorCode::kNotFound, "the system does not resolve it")
                                     : local_address_towards(address, master_at->port);
  host = in_uri(local ? *local : host_name());
  if (!local) {
    log(params.name + " cannot determine its address for " + master_at->host + " (" + local.error().message +
        ") and advertises " + host + "; " + params.advertised_host_remedy);
  }
  return {};
}

Result<void> PeerCore::open() {
  const auto master_at = parse_uri(params.master_uri);
  if (!master_at) return tl::unexpected<Error>(master_at.error());
  if (params.name.size() < 2 || params.name.front() != '/') {
    return fail(ErrorCode::kInvalidArgument,
                "'" + params.name + "' is not a node name: it must begin with '/'");
  }
  if (auto found = find_host(); !found) return found;
  const std::weak_ptr<PeerCore> weak = weak_from_this();
  const auto rpc_port =
      server.open(params.bind_address, 0, [weak](const XmlCall& call, const std::string& from) {
        const auto self = weak.lock();
        return self ? answer_slave_call(*self, call, from) : XmlValue(XmlArray{-1, "the node is gone", 0});
      });
  if (!rpc_port) return tl::unexpected<Error>(rpc_port.error());
  const auto stream_port = listener.open(params.bind_address);
  if (!stream_port) return tl::unexpected<Error>(stream_port.error());
  tcpros_port = *stream_port;
  uri = "http://" + host + ":" + std::to_string(*rpc_port) + "/";
  MasterLink::Params link{params.master_uri, params.name, uri, params.master_period, params.master_timeout};
  MasterLink::Handlers on_master{[weak](const Peer::MasterStatus& status) {
                                   const auto self = weak.lock();
                                   if (self && !self->closed && self->handlers.on_master)
                                     self->handlers.on_master(status);
                                 },
                                 [weak](const std::string& line) {
                                   if (const auto self = weak.lock()) self->log(line);
                                 }};
  master = std::make_unique<MasterLink>(loop, client, std::move(link), std::move(on_master));
  return {};
}

void PeerCore::close() {
  closed = true;
  listener.close();
  server.close();
}

ConnectionHeader PeerCore::own_header() const {
  ConnectionHeader header{{"callerid", params.name}};
  if (params.marked) header[kTranslatorKey] = params.name;
  return header;
}

std::string PeerCore::mark_in(const ConnectionHeader& header) const {
  return params.marked ? value_of(header, kTranslatorKey) : std::string();
}

void PeerCore::log(const std::string& line) {
  if (closed || !handlers.on_log) return;
  if (!log_window_open_) open_log_window();
  if (lines_left_ == 0) {
    ++lines_dropped_;
    return;
  }
  --lines_left_;
  handlers.on_log(line);
}

void PeerCore::open_log_window() {
  log_window_open_ = true;
  loop.after(kLogWindow, [weak = weak_from_this()] {
    const auto self = weak.lock();
    if (!self || self->closed) return;
    self->log_window_open_ = false;
    self->lines_left_ = kLinesAtOnce;
    const auto dropped = std::exchange(self->lines_dropped_, 0);
    if (dropped > 0) self->log(std::to_string(dropped) + " similar lines were suppressed");
  });
}

void PeerCore::lose_carrier(const std::vector<std::string>& addresses) {
  for (const auto& [topic, publication] : publications) publication->lose_carrier(addresses);
}

void PeerCore::dispatch(Incoming incoming) {
  if (closed) return;
  const auto refuse = [&](const std::string& reason) {
    send_refusal(incoming.socket.get(), own_header(), reason);
  };
  const auto service = incoming.header.find("service");
  if (service != incoming.header.end()) {
    auto* const state = newest(services, service->second);
    if (state == nullptr) return refuse(params.name + " does not serve " + service->second);
    return state->shared_from_this()->incoming(std::move(incoming));
  }
  const auto topic = incoming.header.find("topic");
  if (topic == incoming.header.end())
    return refuse("the connection header names neither a topic nor a service");
  auto* const state = newest(publications, topic->second);
  if (state == nullptr) return refuse(params.name + " does not publish " + topic->second);
  state->shared_from_this()->incoming(std::move(incoming));
}

}  // namespace extperfc::translate
