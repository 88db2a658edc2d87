#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace extperfc::ros_mapping {

/// Queue from callbacks to one worker. When it is full the oldest item is dropped and counted.
template <typename T>
class ScanQueue {
 public:
  explicit ScanQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Returns true when an older item was dropped. No effect after close().
  bool put(T item) {
    std::optional<T> displaced;  // destroyed after the lock is released
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return false;
      if (items_.size() >= capacity_) {
        displaced = std::move(items_.front());
        items_.pop_front();
        ++dropped_;
      }
      items_.push_back(std::move(item));
    }
    ready_.notify_one();
    return displaced.has_value();
  }

  /// Waits for an item. No value: closed.
  [[nodiscard]] std::optional<T> take() {
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return closed_ || !items_.empty(); });
    if (closed_) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    return item;
  }

  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
      items_.clear();
    }
    ready_.notify_all();
  }

  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }
  [[nodiscard]] std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return items_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<T> items_;
  const std::size_t capacity_;
  std::uint64_t dropped_{0};
  bool closed_{false};
};

}  // namespace extperfc::ros_mapping
