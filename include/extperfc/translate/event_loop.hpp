#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

namespace extperfc::translate {

/// Which descriptors come first when several are ready: a command does not wait behind an image.
enum class Priority : std::uint8_t { kControl, kNormal, kBulk };

using SteadyTime = std::chrono::steady_clock::time_point;

/// One thread's sockets and timers (epoll, level-triggered). Handlers run on the thread in run(), one at a
/// time, and must not block; they may add and remove anything, themselves included. Everything but post() and
/// stop() is of that thread (or before run()).
class EventLoop {
 public:
  using Handler = std::function<void(std::uint32_t epoll_events)>;
  using TimerId = std::uint64_t;  ///< 0 is none

  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// The descriptor stays the caller's. A handler never runs again after unwatch(), even when its event was
  /// already fetched and the number was used again by another file.
  void watch(int descriptor, std::uint32_t epoll_events, Priority priority, Handler handler);
  void change(int descriptor, std::uint32_t epoll_events);
  void set_priority(int descriptor, Priority priority);
  void unwatch(int descriptor);

  /// Once, not before `delay` has passed.
  TimerId after(std::chrono::nanoseconds delay, std::function<void()> task);
  void cancel(TimerId timer);  ///< nothing happens when it has run or is 0
  /// Runs soon on the loop's thread. From any thread.
  void post(std::function<void()> task);

  void run();   ///< until stop()
  void stop();  ///< from any thread
  /// One round: waits for `at_most`, handles what is ready. For tests and simple programs.
  void run_once(std::chrono::nanoseconds at_most);

  [[nodiscard]] static SteadyTime now() { return std::chrono::steady_clock::now(); }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace extperfc::translate
