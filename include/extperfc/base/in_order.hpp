#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace extperfc {

/// Lets results that several threads compute leave in the order in which their work began.
///
/// Each thread takes the next ticket when it starts and waits for its turn before it hands its result on.
class InOrder {
 public:
  /// The next ticket, from 0 upwards. Every ticket must be passed to finish(), whatever became of the work.
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
      turn_.wait(lock, [&] { return turn_ticket_ == ticket; });
    }
    deliver();
    {
      const std::lock_guard lock(mutex_);
      ++turn_ticket_;
    }
    turn_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable turn_;
  std::uint64_t next_{0};
  std::uint64_t turn_ticket_{0};
};

}  // namespace extperfc
