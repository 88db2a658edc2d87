#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace extperfc {

/// Lets results that several threads compute leave in the order in which their work began.
///
/// Each thread takes the next ticket when it starts and waits until the earlier ones are finished before it
/// hands its result on.
class InOrder {
 public:
  /// The next ticket, from 0 upwards. Every ticket must be passed to finish(), also after a failure.
  [[nodiscard]] std::uint64_t begin() {
    const std::lock_guard lock(mutex_);
    return next_++;
  }

  /// Waits until every earlier ticket is finished, runs `deliver` without holding a lock, and finishes the
  /// ticket.
  template <typename Deliver>
  void finish(std::uint64_t ticket, Deliver&& deliver) {
    {
      std::unique_lock lock(mutex_);
      finished_.wait(lock, [&] { return next_to_finish_ == ticket; });
    }
    deliver();
    {
      const std::lock_guard lock(mutex_);
      ++next_to_finish_;
    }
    finished_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable finished_;
  std::uint64_t next_{0};
  std::uint64_t next_to_finish_{0};
};

}  // namespace extperfc
