#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace extperfc {

/// A mailbox for one item in which the newest replaces an older one that still waits.
///
/// Between a callback that must not block and a worker that takes its time. Replaced items are counted, never
/// queued, so memory and latency stay bounded. Any number of threads may put() and take(); one item goes to
/// one taker.
template <typename T>
class LatestSlot {
 public:
  /// Stores `item`. Returns true when it replaced one that was not taken (a drop). Does nothing after
  /// close().
  bool put(T item) {
    std::optional<T> replaced;  // destroyed after the lock is released: an image may be large
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return false;
      replaced.swap(item_);
      item_.emplace(std::move(item));
      if (replaced) ++dropped_;
    }
    ready_.notify_one();
    return replaced.has_value();
  }

  /// Waits for an item. Empty: closed.
  [[nodiscard]] std::optional<T> take() {
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return item_ || closed_; });
    return take_locked();
  }

  /// Waits for an item, `timeout` at most. Empty: closed or timed out.
  template <typename Duration>
  [[nodiscard]] std::optional<T> take_for(Duration timeout) {
    std::unique_lock lock(mutex_);
    ready_.wait_for(lock, timeout, [this] { return item_ || closed_; });
    return take_locked();
  }

  /// Wakes every waiting taker; items put afterwards are ignored and one that waits is discarded.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
      item_.reset();
    }
    ready_.notify_all();
  }

  /// Items that were replaced before anybody took them.
  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  std::optional<T> take_locked() { return std::exchange(item_, std::nullopt); }

  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::optional<T> item_;
  std::uint64_t dropped_{0};
  bool closed_{false};
};

}  // namespace extperfc
