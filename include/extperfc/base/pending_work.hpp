#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace extperfc {

/// Work that waits for one worker, between callbacks that must not block: they change what waits, the worker
/// takes all of it at once. `Work{}` is nothing to do. Any number of threads may change(); one takes.
template <typename Work>
class PendingWork {
 public:
  /// `apply(Work&)` under the lock; does nothing after close().
  template <typename Change>
  void change(const Change& apply) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    if (!waiting_) waiting_.emplace();
    apply(*waiting_);
    ready_.notify_one();
  }

  /// Waits for work. No value: closed.
  [[nodiscard]] std::optional<Work> take() {
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return waiting_ || closed_; });
    if (closed_) return std::nullopt;
    return std::exchange(waiting_, std::nullopt);
  }

  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    ready_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable ready_;
  std::optional<Work> waiting_;
  bool closed_{false};
};

}  // namespace extperfc
