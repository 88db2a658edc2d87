#include "translate/peer/tcpros_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace extperfc::translate {
namespace {

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

Result<AddressList> numeric(const std::string& address, std::uint16_t port, int socket_kind) {
  addrinfo hints{};
  hints.ai_socktype = socket_kind;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  const auto text = std::to_string(port);
  if (::getaddrinfo(address.c_str(), text.c_str(), &hints, &list) != 0 || list == nullptr) {
    return fail(ErrorCode::kInvalidArgument, "'" + address + "' is not a numeric address");
  }
  return AddressList(list, ::freeaddrinfo);
}

void set_option(int descriptor, int level, int name, int value) {
  ::setsockopt(descriptor, level, name, &value, sizeof(value));
}

std::string numeric_host(const sockaddr_storage& address, socklen_t size) {
  char host[NI_MAXHOST] = "";
  const auto* any = reinterpret_cast<const sockaddr*>(&address);
  if (::getnameinfo(any, size, host, sizeof(host), nullptr, 0, NI_NUMERICHOST) != 0) return "?";
  return host;
}

int seconds(std::chrono::milliseconds time) {
  return std::max(1, static_cast<int>(std::chrono::ceil<std::chrono::seconds>(time).count()));
}

}  // namespace

std::string errno_text(int number) {
  return std::system_category().message(number);
}

void LoopSocket::watch(EventLoop& loop, std::uint32_t events, Priority priority, EventLoop::Handler handler) {
  unwatch();
  loop.watch(descriptor_, events, priority, std::move(handler));
  loop_ = &loop;
  events_ = events;
}

void LoopSocket::want(std::uint32_t events) {
  if (loop_ == nullptr || events == events_) return;
  loop_->change(descriptor_, events);
  events_ = events;
}

void LoopSocket::set_priority(Priority priority) {
  if (loop_ != nullptr) loop_->set_priority(descriptor_, priority);
}

void LoopSocket::unwatch() {
  if (loop_ != nullptr) loop_->unwatch(descriptor_);
  loop_ = nullptr;
}

void LoopSocket::close() {
  unwatch();
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

Result<ListeningSocket> listen_on(const std::string& address, std::uint16_t port) {
  const auto list = numeric(address, port, SOCK_STREAM);
  if (!list) return tl::unexpected<Error>(list.error());
  const auto* at = list->get();
  LoopSocket socket(::socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  set_option(socket.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  set_option(socket.get(), SOL_SOCKET, SO_REUSEPORT, 1);  // for HalfOpenNotices
  if (!socket || ::bind(socket.get(), at->ai_addr, at->ai_addrlen) != 0 ||
      ::listen(socket.get(), SOMAXCONN) != 0) {
    return fail(ErrorCode::kFailed, "cannot listen at " + address + ":" + std::to_string(port) + ": " +
                                        errno_text(errno) + "; choose another bind address");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof(bound);
  ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&bound), &size);
  const auto bound_port = bound.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                                      : reinterpret_cast<const sockaddr_in&>(bound).sin_port;
  return ListeningSocket{std::move(socket), ntohs(bound_port)};
}

Result<LoopSocket> begin_connect(const std::string& address, std::uint16_t port) {
  const auto list = numeric(address, port, SOCK_STREAM);
  if (!list) return tl::unexpected<Error>(list.error());
  const auto* at = list->get();
  LoopSocket socket(::socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket || (::connect(socket.get(), at->ai_addr, at->ai_addrlen) != 0 && errno != EINPROGRESS)) {
    return fail(ErrorCode::kFailed,
                "cannot connect to " + address + ":" + std::to_string(port) + ": " + errno_text(errno));
  }
  return socket;
}

std::string connect_problem(int descriptor) {
  int problem = 0;
  socklen_t size = sizeof(problem);
  if (::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &problem, &size) != 0) problem = errno;
  return problem == 0 ? std::string() : errno_text(problem);
}

void tune(int descriptor, const TcprosParams& params) {
  constexpr int kProbes = 3;
  set_option(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(descriptor, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, seconds(params.keep_alive));
  set_option(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, seconds(params.keep_alive / 2));
  set_option(descriptor, IPPROTO_TCP, TCP_KEEPCNT, kProbes);
  set_unacknowledged(descriptor, params.unacknowledged);
}

void set_unacknowledged(int descriptor, std::chrono::milliseconds patience) {
  set_option(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, static_cast<int>(patience.count()));
}

void set_unsent(int descriptor, Priority priority) {
  // Control: what has not left yet waits in our queue, where it may grow too old and be dropped. Normal:
  // enough to keep a stream of large messages as fast as without a bound. Bulk: the system's default, none.
  constexpr int kControl = 1;
  constexpr int kNormal = 1 << 20;
  constexpr int kNone = -1;
  const auto bytes = priority == Priority::kControl  ? kControl
                     : priority == Priority::kNormal ? kNormal
                                                     : kNone;
  set_option(descriptor, IPPROTO_TCP, TCP_NOTSENT_LOWAT, bytes);
}

int unacknowledged_bytes(int descriptor) {
  int bytes = 0;
  return ::ioctl(descriptor, TIOCOUTQ, &bytes) == 0 ? bytes : 0;
}

std::string local_address(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return "?";
  return numeric_host(address, size);
}

std::string remote_address(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (::getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return "?";
  return numeric_host(address, size);
}

Result<std::string> local_address_towards(const std::string& address, std::uint16_t port) {
  const auto list = numeric(address, port, SOCK_DGRAM);
  if (!list) return tl::unexpected<Error>(list.error());
  const auto* at = list->get();
  const LoopSocket socket(::socket(at->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket || ::connect(socket.get(), at->ai_addr, at->ai_addrlen) != 0) {
    return fail(ErrorCode::kFailed, "no route to " + address + ": " + errno_text(errno));
  }
  sockaddr_storage local{};
  socklen_t size = sizeof(local);
  ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&local), &size);
  return numeric_host(local, size);
}

void send_refusal(int descriptor, ConnectionHeader own, const std::string& reason) {
  own["error"] = reason;
  const auto bytes = encode_header(own);
  const auto sent = ::send(descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent < 0) return;  // it left already
  // What is left unread would make the system reset the connection, and the reason would be lost.
  ::shutdown(descriptor, SHUT_WR);
  char rest[4096];
  for (int i = 0; i < 16; ++i) {
    if (::recv(descriptor, rest, sizeof(rest), MSG_DONTWAIT) <= 0) break;
  }
}

}  // namespace extperfc::translate
