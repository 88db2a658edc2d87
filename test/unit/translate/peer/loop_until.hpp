#pragma once

#include <chrono>

#include "extperfc/translate/event_loop.hpp"

namespace extperfc::translate {

/// Runs the loop until the condition holds; false when it does not within `patience`.
template <typename Condition>
[[nodiscard]] bool loop_until(EventLoop& loop, const Condition& condition,
                              std::chrono::milliseconds patience = std::chrono::seconds(20)) {
  const auto end = EventLoop::now() + patience;
  while (!condition()) {
    if (EventLoop::now() > end) return false;
    loop.run_once(std::chrono::milliseconds(10));
  }
  return true;
}

/// Runs the loop for some time, to see that something does not happen.
inline void loop_for(EventLoop& loop, std::chrono::milliseconds time) {
  const auto end = EventLoop::now() + time;
  while (EventLoop::now() < end) loop.run_once(std::chrono::milliseconds(5));
}

}  // namespace extperfc::translate
