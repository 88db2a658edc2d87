#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "extperfc/simulate/simulator.hpp"

#include "ros/simulate/sim_host.hpp"

namespace extperfc::ros_test {

/// A simulation that goes on only while the test makes it: the test's own thread is the simulation thread, so
/// that what happens between two steps is known. Sets ROS's clock.
class SteppedHost : public ros_simulate::SimHost {
 public:
  explicit SteppedHost(std::unique_ptr<simulate::Simulator> simulator) : simulator_(std::move(simulator)) {}

  bool post(std::function<void(simulate::Simulator&)> work) override;
  void after_step(std::function<void(const simulate::Simulator&, const ros::Time&)> publish) override {
    after_step_.push_back(std::move(publish));
  }

  /// As many steps as that much simulated time takes.
  void advance(double duration_s);
  /// Goes on, some ten times faster than real time, until the condition holds; false when it does not within
  /// the tests' patience.
  [[nodiscard]] bool advance_until(const std::function<bool()>& condition);
  /// Only what was posted, as while paused.
  void run_posted();
  /// From now on post() refuses, as at the end of a simulation.
  void close() { closed_ = true; }

  /// How often post() was called with success so far.
  [[nodiscard]] std::size_t posted() const { return posted_; }
  [[nodiscard]] simulate::Simulator& simulator() { return *simulator_; }
  [[nodiscard]] ros::Time stamp() const;

 private:
  static constexpr double kStartTimeS = 1.0;  // ROS's time 0 means "not set"

  std::unique_ptr<simulate::Simulator> simulator_;
  std::vector<std::function<void(const simulate::Simulator&, const ros::Time&)>> after_step_;
  std::mutex mutex_;
  std::deque<std::function<void(simulate::Simulator&)>> waiting_;
  std::atomic<std::size_t> posted_{0};
  std::atomic<bool> closed_{false};
};

}  // namespace extperfc::ros_test
