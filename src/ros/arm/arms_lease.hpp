#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace extperfc::ros_arm {

/// Permission to move the arms: one holder at a time; the latest request supersedes older ones. Thread-safe.
class ArmsLease {
 public:
  /// The permission, until it is destroyed.
  class Hold {
   public:
    Hold(ArmsLease& lease, std::uint64_t ticket, bool holds)
        : lease_(lease), ticket_(ticket), holds_(holds) {}
    Hold(const Hold&) = delete;
    Hold& operator=(const Hold&) = delete;
    ~Hold() {
      if (holds_) lease_.give_back();
    }
    /// True when a newer request waits: the motion must stop. True from the start when it arrived while this
    /// one waited.
    [[nodiscard]] bool superseded() const { return lease_.newest() != ticket_; }

   private:
    ArmsLease& lease_;
    const std::uint64_t ticket_;
    const bool holds_;
  };

  /// Waits until the previous holder ends, or until a newer request arrives.
  [[nodiscard]] Hold take() {
    std::unique_lock lock(mutex_);
    const std::uint64_t ticket = ++newest_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !held_ || newest_ != ticket; });
    const bool holds = newest_ == ticket;
    if (holds) held_ = true;
    return {*this, ticket, holds};
  }

 private:
  void give_back() {
    const std::lock_guard lock(mutex_);
    held_ = false;
    changed_.notify_all();
  }
  [[nodiscard]] std::uint64_t newest() const {
    const std::lock_guard lock(mutex_);
    return newest_;
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t newest_{0};
  bool held_{false};
};

}  // namespace extperfc::ros_arm
