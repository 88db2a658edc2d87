#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "extperfc/translate/event_loop.hpp"

namespace extperfc::translate {

/// Nodes whose connection to one topic was lost, and the schedule of the calls that make the master notify
/// them. rospy does not reconnect by itself: it waits until the master announces the publisher again
/// (publisherUpdate). The same call also reports publishers that were replaced while a notification was lost.
/// The intervals are first, 2 first, 4 first, ..., up to `last`, until no node is missing. Use on the loop's
/// thread.
class MissingSubscribers {
 public:
  static constexpr std::size_t kMax = 256;  ///< remembered at once; a call reaches the others all the same
  static constexpr std::chrono::milliseconds kSoon{200};  ///< for a node to notice that its connection ended

  /// `call` must not destroy this object.
  MissingSubscribers(EventLoop& loop, std::function<void()> call, std::chrono::milliseconds first,
                     std::chrono::milliseconds last)
      : loop_(loop), call_(std::move(call)), first_(first), last_(last) {}
  ~MissingSubscribers() { clear(); }
  MissingSubscribers(const MissingSubscribers&) = delete;
  MissingSubscribers& operator=(const MissingSubscribers&) = delete;

  /// It is missing; the schedule begins with the first one.
  void expect(const std::string& name);
  /// It connected, or is known not to reconnect.
  void forget(const std::string& name);
  void clear();
  /// A call is likely to succeed now: the next call comes soon, and the schedule restarts after it.
  void hurry();

  [[nodiscard]] bool empty() const { return names_.empty(); }
  [[nodiscard]] const std::set<std::string>& names() const { return names_; }
  /// Calls since the first one of those that are missing now went, or since hurry().
  [[nodiscard]] int calls() const { return calls_; }

 private:
  void arm(std::chrono::milliseconds delay);
  void call();

  EventLoop& loop_;
  std::function<void()> call_;
  std::chrono::milliseconds first_, last_, delay_{0};
  std::set<std::string> names_;
  EventLoop::TimerId timer_{0};
  int calls_{0};
};

}  // namespace extperfc::translate
