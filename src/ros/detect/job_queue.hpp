#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <sensor_msgs/Image.h>

#include "extperfc/base/latest_slot.hpp"
#include "extperfc/detect/detector.hpp"

namespace extperfc::ros_detect {

/// What became of the image of a request.
struct Answer {
  std_msgs::Header header;  ///< of the image
  Result<detect::DetectorOutput> output;
};

/// Where the service waits for its answer; closed when there will be none.
using Mailbox = LatestSlot<Answer>;

/// An image for the network.
struct Job {
  sensor_msgs::ImageConstPtr message;
  bool publish{true};                ///< on the topics
  std::shared_ptr<Mailbox> mailbox;  ///< of the request that wants it; null: none
};

/// Images that wait for the network: the newest of the stream, which replaces an older one, and before it one
/// that a request waits for, which nothing replaces but another request. Any number of threads.
class JobQueue {
 public:
  void put(Job job) {
    Job replaced;  // destroyed after the lock is released: an image may be large
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return;
      auto& place = job.mailbox ? requested_ : newest_;
      if (place) {
        replaced = std::move(*place);
        if (!job.mailbox) ++dropped_;
      }
      place.emplace(std::move(job));
    }
    ready_.notify_one();
  }

  /// Waits for a job. Empty: closed.
  [[nodiscard]] std::optional<Job> take() {
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [this] { return requested_ || newest_ || closed_; });
    if (closed_) return std::nullopt;
    return std::exchange(requested_ ? requested_ : newest_, std::nullopt);
  }

  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    ready_.notify_all();
  }

  /// Images of the stream that were replaced before anybody took them.
  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  std::optional<Job> requested_;
  std::optional<Job> newest_;
  std::uint64_t dropped_{0};
  bool closed_{false};
};

}  // namespace extperfc::ros_detect
