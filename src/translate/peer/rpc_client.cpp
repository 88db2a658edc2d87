#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <optional>
#include <utility>

#include <sys/epoll.h>
#include <sys/socket.h>

#include "extperfc/translate/rpc.hpp"

#include "translate/peer/http_message.hpp"
#include "translate/peer/socket.hpp"

namespace extperfc::translate {
namespace {

/// How long an unused connection is kept: longer than the period at which masters are asked whether they
/// live.
constexpr std::chrono::milliseconds kKeptOpen{5'000};

struct Call {
  std::uint64_t id{0};
  std::string label;  ///< method and URI, for errors
  std::string request;
  std::chrono::milliseconds timeout{0};
  RpcClient::Done done;
  EventLoop::TimerId timer{0};
  bool repeated{false};
};

}  // namespace

struct RpcClient::State : std::enable_shared_from_this<RpcClient::State> {
  /// One connection at a time: calls to one server are answered in the order in which they were made.
  struct Server {
    Server(std::string name, HostPort where, const RpcLimits& limits)
        : key(std::move(name)), place(std::move(where)), reader(HttpReader::Kind::kResponse, limits) {}

    std::string key;
    HostPort place;
    std::deque<Call> waiting;
    std::optional<Call> active;
    bool start_posted{false};
    std::uint64_t attempt{0};  ///< of a connection; answers of the resolver to earlier ones are void
    Socket socket;
    bool connected{false};
    bool used{false};       ///< has answered on this connection
    bool answering{false};  ///< a byte of the answer has come
    HttpReader reader;
    std::string input;
    std::size_t sent{0};
    EventLoop::TimerId idle{0};
  };
  using ServerPtr = std::shared_ptr<Server>;

  State(EventLoop& on, Resolver& names, RpcLimits bounds) : loop(on), resolver(names), limits(bounds) {}

  EventLoop& loop;
  Resolver& resolver;
  RpcLimits limits;
  std::map<std::string, ServerPtr> servers;
  std::uint64_t last_id{0};
  std::array<char, kReadAtOnce> chunk{};

  void forget_all() {
    for (const auto& [key, server] : servers) {
      close(*server);
      if (server->active) loop.cancel(server->active->timer);
      for (const auto& call : server->waiting) loop.cancel(call.timer);
    }
    servers.clear();
  }

  void add(const ServerPtr& server, Call call) {
    call.id = ++last_id;
    call.timer = loop.after(call.timeout, [weak = weak_from_this(), server, id = call.id] {
      if (const auto self = weak.lock()) self->expire(server, id);
    });
    server->waiting.push_back(std::move(call));
    start_soon(server);
  }

  /// Never inside call(), because a failure would run `done` there.
  void start_soon(const ServerPtr& server) {
    if (server->active || server->waiting.empty() || std::exchange(server->start_posted, true)) return;
    loop.post([weak = weak_from_this(), server] {
      server->start_posted = false;
      if (const auto self = weak.lock()) self->start(server);
    });
  }

  void start(const ServerPtr& server) {
    if (server->active) return;
    if (server->waiting.empty()) return forget_unused(server);
    server->active = std::move(server->waiting.front());
    server->waiting.pop_front();
    loop.cancel(std::exchange(server->idle, 0));
    if (server->connected)
      begin_request(server);
    else
      find_address(server);
  }

  void find_address(const ServerPtr& server) {
    const auto attempt = ++server->attempt;
    resolver.resolve(server->place.host,
                     [weak = weak_from_this(), server, attempt](const Result<std::string>& address) {
                       const auto self = weak.lock();
                       if (self && server->active && server->attempt == attempt)
                         self->connect_to(server, address);
                     });
  }

  void connect_to(const ServerPtr& server, const Result<std::string>& address) {
    if (!address) return fail_active(server, address.error().code, address.error().message);
    auto socket = start_connection(*address, server->place.port);
    if (!socket) return fail_active(server, socket.error().code, socket.error().message);
    server->socket = std::move(*socket);
    loop.watch(server->socket.get(), EPOLLOUT, Priority::kNormal,
               [weak = weak_from_this(), server](std::uint32_t events) {
                 if (const auto self = weak.lock()) self->handle(server, events);
               });
  }

  void handle(const ServerPtr& server, std::uint32_t events) {
    if (!server->connected) {
      if (const int error = connection_error(server->socket.get()); error != 0)
        return fail_active(server, ErrorCode::kFailed, system_message(error));
      server->connected = true;
      return begin_request(server);
    }
    if ((events & ~static_cast<std::uint32_t>(EPOLLOUT)) != 0) return receive(server);
    if (server->active) send(server);
  }

  void begin_request(const ServerPtr& server) {
    server->sent = 0;
    server->answering = false;
    send(server);
  }

  void send(const ServerPtr& server) {
    const auto& request = server->active->request;
    while (server->sent < request.size()) {
      const auto count = ::send(server->socket.get(), request.data() + server->sent,
                                request.size() - server->sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0 && errno == EAGAIN) return loop.change(server->socket.get(), EPOLLIN | EPOLLOUT);
      if (count < 0) return lost(server, system_message(errno));
      server->sent += static_cast<std::size_t>(count);
    }
    loop.change(server->socket.get(), EPOLLIN);
  }

  void receive(const ServerPtr& server) {
    const auto count = ::recv(server->socket.get(), chunk.data(), chunk.size(), 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count < 0) return lost(server, system_message(errno));
    if (count == 0) return ended(server);
    if (!server->active) return close_idle(server);  // no request is waiting
    server->answering = true;
    server->input.append(chunk.data(), static_cast<std::size_t>(count));
    proceed(server, server->reader.read(server->input));
  }

  void ended(const ServerPtr& server) {
    if (!server->active || !server->answering)
      return lost(server, "the connection was closed without an answer");
    proceed(server, server->reader.end_of_stream());
  }

  void proceed(const ServerPtr& server, HttpReader::Step step) {
    if (step == HttpReader::Step::kBroken)
      return fail_active(server, ErrorCode::kCorrupt, "not an HTTP response: " + server->reader.problem());
    if (step != HttpReader::Step::kDone) return;
    const auto message = server->reader.take();
    server->used = true;
    if (!message.keep_alive || !server->input.empty() || server->sent < server->active->request.size())
      close(*server);
    if (message.status != 200)
      return finish(
          server, fail(ErrorCode::kFailed, label(server) + "HTTP status " + std::to_string(message.status)));
    auto value = decode_response(message.body, limits);
    if (!value) value = fail(value.error().code, label(server) + value.error().message);
    finish(server, std::move(value));
  }

  /// A connection that was kept open may have been closed by the server meanwhile: then the call is made once
  /// more. Nothing was answered, so nothing is known to have been done.
  void lost(const ServerPtr& server, const std::string& reason) {
    if (!server->active) return close_idle(server);
    const bool once_more =
        server->used && !server->answering && !std::exchange(server->active->repeated, true);
    if (!once_more) return fail_active(server, ErrorCode::kFailed, reason);
    close(*server);
    find_address(server);
  }

  void close(Server& server) {
    ++server.attempt;
    if (server.socket) loop.unwatch(server.socket.get());
    server.socket.reset();
    server.connected = server.used = server.answering = false;
    server.input.clear();
    server.reader = HttpReader(HttpReader::Kind::kResponse, limits);
    loop.cancel(std::exchange(server.idle, 0));
  }

  void close_idle(const ServerPtr& server) {
    close(*server);
    forget_unused(server);
  }

  void forget_unused(const ServerPtr& server) {
    const auto found = servers.find(server->key);
    const bool unused = !server->active && server->waiting.empty() && !server->connected;
    if (unused && found != servers.end() && found->second == server) servers.erase(found);
  }

  [[nodiscard]] static std::string label(const ServerPtr& server) { return server->active->label + ": "; }

  void fail_active(const ServerPtr& server, ErrorCode code, const std::string& problem) {
    close(*server);
    finish(server, fail(code, label(server) + problem));
  }

  void finish(const ServerPtr& server, Result<XmlValue> result) {
    const auto call = std::move(*server->active);
    server->active.reset();
    loop.cancel(call.timer);
    if (!server->waiting.empty()) {
      start_soon(server);
    } else if (server->connected) {
      server->idle = loop.after(kKeptOpen, [weak = weak_from_this(), server] {
        if (const auto self = weak.lock()) self->close_idle(server);
      });
    } else {
      forget_unused(server);
    }
    call.done(std::move(result));  // may end the client
  }

  void expire(const ServerPtr& server, std::uint64_t id) {
    const auto problem = [](const Call& call) {
      return "no answer within " + std::to_string(call.timeout.count()) + " ms";
    };
    if (server->active && server->active->id == id)
      return fail_active(server, ErrorCode::kFailed, problem(*server->active));
    const auto found = std::find_if(server->waiting.begin(), server->waiting.end(),
                                    [id](const Call& call) { return call.id == id; });
    if (found == server->waiting.end()) return;
    const auto call = std::move(*found);
    server->waiting.erase(found);
    call.done(fail(ErrorCode::kFailed, call.label + ": " + problem(call)));
  }
};

RpcClient::RpcClient(EventLoop& loop, Resolver& resolver, RpcLimits limits)
    : state_(std::make_shared<State>(loop, resolver, limits)) {}

RpcClient::~RpcClient() {
  state_->forget_all();
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): the contract leaves room for keeping them
void RpcClient::call(const std::string& uri, const std::string& method, XmlArray arguments,
                     std::chrono::milliseconds timeout, Done done) {
  const auto fail_later = [&](Error error) {
    state_->loop.post(
        [weak = std::weak_ptr<State>(state_), done = std::move(done), error = std::move(error)] {
          if (const auto self = weak.lock()) done(tl::unexpected(error));
        });
  };
  const auto label = method + " at " + uri;
  const auto place = parse_uri(uri);
  if (!place) return fail_later({place.error().code, method + ": " + place.error().message});
  const auto key = place->host + ' ' + std::to_string(place->port);
  auto& server = state_->servers[key];
  if (!server) server = std::make_shared<State::Server>(key, *place, state_->limits);
  if (server->waiting.size() >= kWaiting)
    return fail_later({ErrorCode::kFailed, label + ": " + std::to_string(kWaiting) + " calls wait already"});
  Call call;
  call.label = label;
  call.request =
      http_request(place->host + ':' + std::to_string(place->port), "/", encode_call(method, arguments));
  call.timeout = timeout;
  call.done = std::move(done);
  state_->add(server, std::move(call));
}

}  // namespace extperfc::translate
