#pragma once

#include <cstdint>
#include <functional>
#include <map>

#include <netinet/in.h>
#include <sys/socket.h>

#include "extperfc/translate/event_loop.hpp"

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {

/// Both addresses of a connection; known only while it stands.
struct ConnectionEnds {
  sockaddr_storage local{}, remote{};
  socklen_t size{0};  ///< 0: not known
};
[[nodiscard]] ConnectionEnds ends_of(int descriptor);

/// Closes with a reset instead of what still waits in the kernel: stale messages must not leave any more.
void abort_connection(LoopSocket& socket);

/// Notifies the other ends of connections that we gave up. Our reset is lost when the network
/// is away, and a subscriber that only listens would then wait on its half-open connection until its
/// keep-alive, more than a minute. A connection request between the same two addresses makes its kernel
/// answer; ours resets that answer, which ends the old connection (RFC 793, section 3.4, "Half-Open
/// Connections"). Requests are repeated until the other end answers. Of the loop's thread.
class HalfOpenNotices {
 public:
  explicit HalfOpenNotices(EventLoop& loop) : loop_(loop) {}
  ~HalfOpenNotices();
  HalfOpenNotices(const HalfOpenNotices&) = delete;
  HalfOpenNotices& operator=(const HalfOpenNotices&) = delete;

  /// The old socket must be closed already. `done` runs once, when the other end has answered and so knows,
  /// or is not there any more; never when it cannot be reached in the end.
  void notify(const ConnectionEnds& ends, std::function<void()> done);
  [[nodiscard]] std::size_t pending() const { return notices_.size(); }

 private:
  struct Notice {
    ConnectionEnds ends;
    std::function<void()> done;
    LoopSocket socket;
    EventLoop::TimerId timer{0};
    int tries{0};
  };
  void attempt(std::uint64_t id);
  void answered(std::uint64_t id);
  void again(std::uint64_t id);
  void finish(std::uint64_t id);
  void forget(std::uint64_t id);

  EventLoop& loop_;
  std::map<std::uint64_t, Notice> notices_;
  std::uint64_t last_id_{0};
};

}  // namespace extperfc::translate
