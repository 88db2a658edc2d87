#include "translate/peer/tcpros_half_open.hpp"

#include <cerrno>
#include <chrono>
#include <utility>

#include <netinet/tcp.h>
#include <sys/epoll.h>

namespace extperfc::translate {
namespace {

constexpr std::size_t kMax = 1024;  ///< notices at once; more subscribers must find out by themselves
constexpr auto kPeriod = std::chrono::seconds(1);
constexpr int kTries = 120;  ///< by then the other end's own keep-alive has noticed

void set_flag(int descriptor, int name) {
  const int on = 1;
  ::setsockopt(descriptor, SOL_SOCKET, name, &on, sizeof(on));
}

const sockaddr* plain(const sockaddr_storage& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace

ConnectionEnds ends_of(int descriptor) {
  ConnectionEnds ends;
  socklen_t local = sizeof(ends.local);
  socklen_t remote = sizeof(ends.remote);
  const bool known = ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&ends.local), &local) == 0 &&
                     ::getpeername(descriptor, reinterpret_cast<sockaddr*>(&ends.remote), &remote) == 0;
  ends.size = known ? local : 0;
  return ends;
}

void abort_connection(LoopSocket& socket) {
  const linger at_once{1, 0};
  if (socket) ::setsockopt(socket.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  socket.close();
}

HalfOpenNotices::~HalfOpenNotices() {
  for (auto& [id, notice] : notices_) loop_.cancel(notice.timer);
}

void HalfOpenNotices::notify(const ConnectionEnds& ends, std::function<void()> done) {
  if (ends.size == 0 || notices_.size() >= kMax) return;
  const auto id = ++last_id_;
  notices_[id].ends = ends;
  notices_[id].done = std::move(done);
  attempt(id);
}

void HalfOpenNotices::attempt(std::uint64_t id) {
  auto& notice = notices_.at(id);
  if (++notice.tries > kTries) return forget(id);
  const auto& ends = notice.ends;
  notice.socket = LoopSocket(::socket(ends.local.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int descriptor = notice.socket.get();
  // The listening socket has the same port.
  set_flag(descriptor, SO_REUSEADDR);
  set_flag(descriptor, SO_REUSEPORT);
  if (!notice.socket || ::bind(descriptor, plain(ends.local), ends.size) != 0) return again(id);
  if (::connect(descriptor, plain(ends.remote), ends.size) == 0) return finish(id);
  if (errno == ECONNREFUSED) return finish(id);
  if (errno != EINPROGRESS) return again(id);
  notice.socket.watch(loop_, EPOLLOUT, Priority::kNormal, [this, id](std::uint32_t) { answered(id); });
  notice.timer = loop_.after(kPeriod, [this, id] { again(id); });
}

/// Refused or reset: there is nothing at the other end any more. A success cannot be: it is no listener.
void HalfOpenNotices::answered(std::uint64_t id) {
  auto& notice = notices_.at(id);
  int problem = 0;
  socklen_t size = sizeof(problem);
  ::getsockopt(notice.socket.get(), SOL_SOCKET, SO_ERROR, &problem, &size);
  if (problem == 0 || problem == ECONNREFUSED || problem == ECONNRESET) return finish(id);
  again(id);  // no route to it now
}

void HalfOpenNotices::again(std::uint64_t id) {
  auto& notice = notices_.at(id);
  loop_.cancel(notice.timer);
  abort_connection(notice.socket);
  notice.timer = loop_.after(kPeriod, [this, id] { attempt(id); });
}

void HalfOpenNotices::finish(std::uint64_t id) {
  const auto done = std::move(notices_.at(id).done);
  forget(id);
  if (done) done();
}

void HalfOpenNotices::forget(std::uint64_t id) {
  const auto found = notices_.find(id);
  loop_.cancel(found->second.timer);
  abort_connection(found->second.socket);
  notices_.erase(found);
}

}  // namespace extperfc::translate
