#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/event_loop.hpp"
#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate {

/// Owns a descriptor, and its place in the event loop while it is watched.
class LoopSocket {
 public:
  LoopSocket() = default;
  explicit LoopSocket(int descriptor) : descriptor_(descriptor) {}
  LoopSocket(LoopSocket&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)),
        loop_(std::exchange(other.loop_, nullptr)),
        events_(other.events_) {}
  LoopSocket& operator=(LoopSocket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(loop_, other.loop_);
    std::swap(events_, other.events_);
    return *this;
  }
  LoopSocket(const LoopSocket&) = delete;
  LoopSocket& operator=(const LoopSocket&) = delete;
  ~LoopSocket() { close(); }

  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] explicit operator bool() const { return descriptor_ >= 0; }

  /// Replaces a handler that was there.
  void watch(EventLoop& loop, std::uint32_t events, Priority priority, EventLoop::Handler handler);
  /// Only while watched; costs nothing when nothing changes.
  void want(std::uint32_t events);
  void set_priority(Priority priority);
  void unwatch();
  void close();

 private:
  int descriptor_{-1};
  EventLoop* loop_{nullptr};
  std::uint32_t events_{0};
};

struct ListeningSocket {
  LoopSocket socket;
  std::uint16_t port{0};
};
/// Numeric IPv4 or IPv6 address; port 0 takes a free one. Non-blocking.
[[nodiscard]] Result<ListeningSocket> listen_on(const std::string& address, std::uint16_t port);
/// Begins to connect to a numeric address; the socket is writable when that has succeeded or failed.
[[nodiscard]] Result<LoopSocket> begin_connect(const std::string& address, std::uint16_t port);
/// What became of begin_connect(); an empty string is success.
[[nodiscard]] std::string connect_problem(int descriptor);

/// Delay, keep-alive and patience as TcprosParams say.
void tune(int descriptor, const TcprosParams& params);
void set_unacknowledged(int descriptor, std::chrono::milliseconds patience);
/// How much of one stream the kernel may hold unsent, so that queues in user space decide what is dropped.
void set_unsent(int descriptor, Priority priority);
/// Bytes that the other end has not acknowledged yet, or that wait in the kernel.
[[nodiscard]] int unacknowledged_bytes(int descriptor);
/// Our numeric address of a connection, without the port; "?" when it is gone.
[[nodiscard]] std::string local_address(int descriptor);
/// Numeric address of the other end, without the port; "?" when it is gone.
[[nodiscard]] std::string remote_address(int descriptor);
/// Local address that the system uses towards a numeric address; no packet is sent.
[[nodiscard]] Result<std::string> local_address_towards(const std::string& address, std::uint16_t port);

/// Sends a connection header whose `error` says why, beside the fields of `own`, once and without waiting.
void send_refusal(int descriptor, ConnectionHeader own, const std::string& reason);
/// Text of errno for people.
[[nodiscard]] std::string errno_text(int number);

}  // namespace extperfc::translate
