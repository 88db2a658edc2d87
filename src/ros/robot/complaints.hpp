#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

namespace extperfc::ros_robot {

/// Errors about bad input: at once, but one per second at most, so that a sender at 100 Hz does not bury the
/// log. What is left out is counted in the next line. Thread-safe.
class Complaints {
 public:
  using Clock = std::chrono::steady_clock;  // real time: the simulated one may stand still

  /// `log` takes a line; by default it goes to the node's log as an error.
  explicit Complaints(std::function<void(const std::string&)> log = {});

  void report(const std::string& message, Clock::time_point now = Clock::now());

 private:
  std::function<void(const std::string&)> log_;
  std::mutex mutex_;
  std::optional<Clock::time_point> last_;
  unsigned long left_out_{0};
};

}  // namespace extperfc::ros_robot
