#include <array>
#include <cerrno>
#include <exception>
#include <unordered_map>
#include <utility>

#include <sys/epoll.h>
#include <sys/socket.h>

#include "extperfc/translate/rpc.hpp"

#include "translate/peer/http_message.hpp"
#include "translate/peer/socket.hpp"

namespace extperfc::translate {
namespace {

constexpr int kAcceptAtOnce = 32;
constexpr std::chrono::milliseconds kNoDescriptors{100};  ///< pause when the process has no descriptor left
constexpr int kFaultCode = -1;

}  // namespace

struct RpcServer::State : std::enable_shared_from_this<RpcServer::State> {
  using Step = HttpReader::Step;

  struct Connection {
    Connection(Socket open, const RpcLimits& limits)
        : socket(std::move(open)),
          address(peer_address_of(socket.get())),
          reader(HttpReader::Kind::kRequest, limits) {}

    Socket socket;
    std::string address;
    HttpReader reader;
    std::string input, output;
    std::size_t sent{0};
    std::size_t counted{0};  ///< bytes that stand in State::buffered
    bool close_after{false};
    bool in_request{false};
    EventLoop::TimerId timer{0};
  };
  using ConnectionPtr = std::shared_ptr<Connection>;

  State(EventLoop& on, RpcLimits bounds) : loop(on), limits(bounds) {}

  EventLoop& loop;
  RpcLimits limits;
  Answer answer;
  Socket listener;
  EventLoop::TimerId pause{0};
  std::unordered_map<int, ConnectionPtr> connections;  ///< by descriptor
  std::size_t buffered{0};
  std::array<char, kReadAtOnce> chunk{};

  void close_all() {
    if (listener) loop.unwatch(listener.get());
    listener.reset();
    loop.cancel(std::exchange(pause, 0));
    const auto open = connections;
    for (const auto& [descriptor, connection] : open) close(connection);
  }

  void watch_listener() {
    loop.watch(listener.get(), EPOLLIN, Priority::kNormal, [weak = weak_from_this()](std::uint32_t) {
      if (const auto self = weak.lock()) self->accept_some();
    });
  }

  void accept_some() {
    for (int i = 0; i < kAcceptAtOnce && listener; ++i) {
      Socket taken(::accept4(listener.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (taken) {
        if (connections.size() < limits.connections) add(std::move(taken));
        continue;
      }
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) rest();
      if (errno != ECONNABORTED && errno != EINTR) return;
    }
  }

  /// The listener stays ready while it cannot be served: it is left alone for a while.
  void rest() {
    loop.unwatch(listener.get());
    pause = loop.after(kNoDescriptors, [weak = weak_from_this()] {
      const auto self = weak.lock();
      if (self && self->listener) self->watch_listener();
    });
  }

  void add(Socket socket) {
    const int descriptor = socket.get();
    auto connection = std::make_shared<Connection>(std::move(socket), limits);
    connections[descriptor] = connection;
    loop.watch(descriptor, EPOLLIN, Priority::kNormal,
               [weak = weak_from_this(), connection](std::uint32_t events) {
                 if (const auto self = weak.lock()) self->handle(connection, events);
               });
    set_deadline(connection, limits.idle);
  }

  void close(const ConnectionPtr& connection) {
    if (!connection->socket) return;
    loop.cancel(std::exchange(connection->timer, 0));
    loop.unwatch(connection->socket.get());
    connections.erase(connection->socket.get());
    buffered -= std::exchange(connection->counted, 0);
    connection->socket.reset();
  }

  void set_deadline(const ConnectionPtr& connection, std::chrono::milliseconds patience) {
    loop.cancel(connection->timer);
    connection->timer = loop.after(patience, [weak = weak_from_this(), connection] {
      if (const auto self = weak.lock()) self->close(connection);
    });
  }

  void handle(const ConnectionPtr& connection, std::uint32_t events) {
    if ((events & (EPOLLERR | EPOLLHUP)) != 0) return close(connection);
    if ((events & EPOLLOUT) != 0) return flush(connection);
    receive(connection);
  }

  void receive(const ConnectionPtr& connection) {
    const auto count = ::recv(connection->socket.get(), chunk.data(), chunk.size(), 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) return close(connection);
    connection->input.append(chunk.data(), static_cast<std::size_t>(count));
    if (!std::exchange(connection->in_request, true)) set_deadline(connection, limits.request);
    proceed(connection);
  }

  /// Reads on until a request is complete; the next one waits until its answer has left.
  void proceed(const ConnectionPtr& connection) {
    if (!connection->output.empty()) return;  // an answer is on its way: afterwards
    const auto step = connection->reader.read(connection->input);
    count_buffered(*connection);
    if (step == Step::kDone) return respond(connection);
    if (step == Step::kBroken) return refuse(connection, connection->reader.problem_status());
    if (buffered > limits.buffered_bytes) return refuse(connection, 503);
    if (connection->reader.wants_continue()) {
      connection->output = "HTTP/1.1 100 Continue\r\n\r\n";
      flush(connection);
    }
  }

  void count_buffered(Connection& connection) {
    const auto now = connection.reader.buffered() + connection.input.size();
    buffered = buffered - std::exchange(connection.counted, now) + now;
  }

  void refuse(const ConnectionPtr& connection, int status) {
    connection->close_after = true;
    connection->output = http_response(status, false, "");
    flush(connection);
  }

  void respond(const ConnectionPtr& connection) {
    const auto request = connection->reader.take();
    count_buffered(*connection);
    const auto self = shared_from_this();  // `answer` may close us
    const auto body = answer_to(request.body, connection->address);
    if (!connection->socket) return;
    connection->close_after = !request.keep_alive;
    connection->output = http_response(200, request.keep_alive, body);
    flush(connection);
  }

  [[nodiscard]] std::string answer_to(const std::string& body, const std::string& address) const {
    const auto call = decode_call(body, limits);
    if (!call) return encode_fault(kFaultCode, call.error().message);
    const auto respond_with = answer;  // stays whole even when it closes us
    try {
      return encode_response(respond_with(*call, address));
    } catch (const std::exception& problem) {
      return encode_fault(kFaultCode, call->method + ": " + problem.what());
    }
  }

  void flush(const ConnectionPtr& connection) {
    auto& output = connection->output;
    while (connection->sent < output.size()) {
      const auto count = ::send(connection->socket.get(), output.data() + connection->sent,
                                output.size() - connection->sent, MSG_NOSIGNAL);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0 && errno == EAGAIN) return loop.change(connection->socket.get(), EPOLLOUT);
      if (count < 0) return close(connection);
      connection->sent += static_cast<std::size_t>(count);
    }
    output.clear();
    connection->sent = 0;
    if (connection->close_after) return close(connection);
    loop.change(connection->socket.get(), EPOLLIN);
    next_request(connection);
  }

  void next_request(const ConnectionPtr& connection) {
    if (connection->reader.in_body()) return;  // that was only "100 Continue"
    connection->in_request = !connection->input.empty();
    set_deadline(connection, connection->in_request ? limits.request : limits.idle);
    if (!connection->in_request) return;
    // Not at once: others have their turn, and many short requests do not nest.
    loop.post([weak = weak_from_this(), connection] {
      const auto self = weak.lock();
      if (self && connection->socket) self->proceed(connection);
    });
  }
};

RpcServer::RpcServer(EventLoop& loop, RpcLimits limits) : state_(std::make_shared<State>(loop, limits)) {}

RpcServer::~RpcServer() {
  state_->close_all();
}

Result<std::uint16_t> RpcServer::open(const std::string& bind_address, std::uint16_t port, Answer answer) {
  auto listener = listen_at(bind_address, port);
  if (!listener) return tl::unexpected(listener.error());
  close();
  state_->listener = std::move(*listener);
  state_->answer = std::move(answer);
  state_->watch_listener();
  return port_of(state_->listener.get());
}

void RpcServer::close() {
  state_->close_all();
}

}  // namespace extperfc::translate
