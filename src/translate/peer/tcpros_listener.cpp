#include <cerrno>

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "translate/peer/tcpros_handshake.hpp"

namespace extperfc::translate {

struct TcprosListener::State : std::enable_shared_from_this<State> {
  struct Pending {
    LoopSocket socket;
    HeaderReader reader;
    EventLoop::TimerId deadline{0};
  };

  State(EventLoop& a_loop, TcprosParams a_params, ConnectionHeader a_own, OnIncoming a_on_incoming)
      : loop(a_loop),
        params(a_params),
        own(std::move(a_own)),
        on_incoming(std::move(a_on_incoming)),
        spare(::open("/dev/null", O_RDONLY | O_CLOEXEC)) {}

  void accept_all();
  void add(LoopSocket socket);
  void advance(std::uint64_t id);
  void remove(std::uint64_t id);
  void shed_one();
  [[nodiscard]] bool holds_too_much(const Pending& entry) const;

  EventLoop& loop;
  TcprosParams params;
  ConnectionHeader own;
  OnIncoming on_incoming;
  LoopSocket listening;
  LoopSocket spare;  ///< given up for a moment when the process has no descriptors left
  std::map<std::uint64_t, Pending> pending;  ///< by age
  std::uint64_t last_id{0};
};

void TcprosListener::State::accept_all() {
  constexpr int kAtOnce = 64;
  for (int i = 0; i < kAtOnce && listening; ++i) {
    LoopSocket socket(::accept4(listening.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket) {
      add(std::move(socket));
    } else if (errno == EMFILE || errno == ENFILE) {
      shed_one();
    } else if (errno != EINTR && errno != ECONNABORTED) {
      return;
    }
  }
}

void TcprosListener::State::shed_one() {
  // Without this a waiting connection would wake the loop again and again.
  spare.close();
  LoopSocket(::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC)).close();
  spare = LoopSocket(::open("/dev/null", O_RDONLY | O_CLOEXEC));
}

void TcprosListener::State::add(LoopSocket socket) {
  if (pending.size() >= params.links) remove(pending.begin()->first);
  tune(socket.get(), params);
  const auto id = ++last_id;
  auto& entry =
      pending.emplace(id, Pending{std::move(socket), HeaderReader(params.header_bytes)}).first->second;
  const std::weak_ptr<State> weak = weak_from_this();
  entry.deadline = loop.after(params.handshake, [weak, id] {
    if (const auto self = weak.lock()) self->remove(id);
  });
  entry.socket.watch(loop, EPOLLIN, Priority::kNormal, [weak, id](std::uint32_t) {
    if (const auto self = weak.lock()) self->advance(id);
  });
}

void TcprosListener::State::advance(std::uint64_t id) {
  auto& entry = pending.at(id);
  const auto outcome = entry.reader.read(entry.socket.get());
  if (outcome == HeaderReader::Outcome::kWaiting) {
    if (!holds_too_much(entry)) return;
    send_refusal(entry.socket.get(), own, "too many large connection headers at once");
    return remove(id);
  }
  if (outcome == HeaderReader::Outcome::kFailed) {
    send_refusal(entry.socket.get(), own, entry.reader.problem());
    return remove(id);
  }
  entry.socket.unwatch();
  Incoming incoming{std::move(entry.socket), std::move(entry.reader.header()), ""};
  remove(id);
  incoming.remote_address = remote_address(incoming.socket.get());
  on_incoming(std::move(incoming));
}

bool TcprosListener::State::holds_too_much(const Pending& entry) const {
  constexpr std::size_t kUsual = 64U << 10U;  // no real header is incomplete at this size for long
  constexpr std::size_t kHeadersAtOnce = 16;
  if (entry.reader.held_bytes() < kUsual) return false;
  std::size_t all = 0;
  for (const auto& [id, other] : pending) all += other.reader.held_bytes();
  return all > kHeadersAtOnce * params.header_bytes;
}

void TcprosListener::State::remove(std::uint64_t id) {
  const auto found = pending.find(id);
  if (found == pending.end()) return;
  loop.cancel(found->second.deadline);
  pending.erase(found);
}

TcprosListener::TcprosListener(EventLoop& loop, TcprosParams params, ConnectionHeader own,
                               OnIncoming on_incoming)
    : state_(std::make_shared<State>(loop, params, std::move(own), std::move(on_incoming))) {}

TcprosListener::~TcprosListener() {
  close();
}

Result<std::uint16_t> TcprosListener::open(const std::string& bind_address) {
  auto listening = listen_on(bind_address, 0);
  if (!listening) return tl::unexpected<Error>(listening.error());
  state_->listening = std::move(listening->socket);
  const std::weak_ptr<State> weak = state_;
  state_->listening.watch(state_->loop, EPOLLIN, Priority::kNormal, [weak](std::uint32_t) {
    if (const auto self = weak.lock()) self->accept_all();
  });
  return listening->port;
}

void TcprosListener::close() {
  state_->listening.close();
  while (!state_->pending.empty()) state_->remove(state_->pending.begin()->first);
}

std::size_t TcprosListener::handshakes() const {
  return state_->pending.size();
}

}  // namespace extperfc::translate
