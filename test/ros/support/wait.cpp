#include "test/ros/support/wait.hpp"

#include <chrono>
#include <thread>

namespace extperfc::ros_test {

bool wait_for(const std::function<bool()>& condition, double patience_s) {
  constexpr std::chrono::milliseconds kPollPeriod{2};
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(kPollPeriod);
  }
  return true;
}

bool never(const std::function<bool()>& condition, double watch_s) {
  return !wait_for(condition, watch_s);
}

}  // namespace extperfc::ros_test
