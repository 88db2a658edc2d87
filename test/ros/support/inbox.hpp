#pragma once

#include <mutex>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "test/ros/support/wait.hpp"

namespace extperfc::ros_test {

/// Collects everything that arrives on a topic. Pointers are kept, so that no address is used twice
/// meanwhile.
template <typename M>
class Inbox {
 public:
  using ConstPtr = boost::shared_ptr<const M>;

  explicit Inbox(const std::string& topic)
      : subscriber_(ros::NodeHandle().subscribe<M>(topic, 1000, [this](const ConstPtr& message) {
          const std::lock_guard lock(mutex_);
          messages_.push_back(message);
        })) {}
  ~Inbox() { subscriber_.shutdown(); }
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;

  [[nodiscard]] std::vector<ConstPtr> all() const {
    const std::lock_guard lock(mutex_);
    return messages_;
  }
  [[nodiscard]] std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return messages_.size();
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    messages_.clear();
  }
  [[nodiscard]] bool connected() const { return subscriber_.getNumPublishers() > 0; }

  /// The message with this stamp, as soon as it comes; null when it does not.
  [[nodiscard]] ConstPtr wait_for_stamp(const ros::Time& stamp) const {
    ConstPtr found;
    (void)wait_for([&] {
      for (const auto& message : all())
        if (message->header.stamp == stamp) found = message;
      return found != nullptr;
    });
    return found;
  }

  [[nodiscard]] bool wait_for_count(std::size_t count_wanted) const {
    return wait_for([&] { return count() >= count_wanted; });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<ConstPtr> messages_;
  ros::Subscriber subscriber_;  // last: nothing arrives after the rest is gone
};

}  // namespace extperfc::ros_test
