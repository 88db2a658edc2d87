#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>

#include "extperfc/translate/event_loop.hpp"

#include "translate/peer/tcpros_socket.hpp"

namespace extperfc::translate {

/// Sees that the other end acknowledges nothing while data waits for it. TCP alone keeps a connection whose
/// other end answers, but never reads, for ever; and its own limit, TCP_USER_TIMEOUT, is looked at only when
/// it sends again, which may be a second late.
class StallWatch {
 public:
  /// `written` counts all bytes that were ever given to the kernel.
  StallWatch(EventLoop& loop, std::function<std::uint64_t()> written, std::function<void()> on_stall)
      : loop_(loop), written_(std::move(written)), on_stall_(std::move(on_stall)) {}
  ~StallWatch() { stop(); }
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  /// From the moment that data waits; `on_stall` runs after `patience` to 1.25 `patience` without progress.
  /// Nothing happens when it runs already. It ends when everything is acknowledged.
  void start(int descriptor, std::chrono::milliseconds patience) {
    if (timer_ != 0 || patience.count() <= 0) return;
    descriptor_ = descriptor;
    period_ = std::max<std::chrono::nanoseconds>(patience / kLooks, std::chrono::milliseconds(1));
    idle_looks_ = 0;
    last_acknowledged_ = acknowledged(unacknowledged_bytes(descriptor_));
    arm();
  }
  void stop() {
    loop_.cancel(timer_);
    timer_ = 0;
  }

 private:
  static constexpr int kLooks = 4;

  void arm() {
    timer_ = loop_.after(period_, [this] { look(); });
  }
  [[nodiscard]] std::int64_t acknowledged(int unacknowledged) const {
    return static_cast<std::int64_t>(written_()) - unacknowledged;
  }
  void look() {
    timer_ = 0;
    const int unacknowledged = unacknowledged_bytes(descriptor_);
    if (unacknowledged == 0) return;
    const bool progress = acknowledged(unacknowledged) > last_acknowledged_;
    last_acknowledged_ = acknowledged(unacknowledged);
    idle_looks_ = progress ? 0 : idle_looks_ + 1;
    if (idle_looks_ < kLooks) return arm();
    const auto on_stall = on_stall_;  // it may destroy this object
    on_stall();
  }

  EventLoop& loop_;
  std::function<std::uint64_t()> written_;
  std::function<void()> on_stall_;
  EventLoop::TimerId timer_{0};
  std::chrono::nanoseconds period_{0};
  int descriptor_{-1};
  int idle_looks_{0};
  std::int64_t last_acknowledged_{0};
};

}  // namespace extperfc::translate
