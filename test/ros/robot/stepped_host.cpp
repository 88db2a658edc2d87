#include "test/ros/robot/stepped_host.hpp"

#include <cmath>
#include <utility>

#include "test/ros/support/wait.hpp"

namespace extperfc::ros_test {

bool SteppedHost::post(std::function<void(simulate::Simulator&)> work) {
  if (closed_) return false;
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(work));
  ++posted_;
  return true;
}

void SteppedHost::run_posted() {
  std::deque<std::function<void(simulate::Simulator&)>> ready;
  {
    const std::lock_guard lock(mutex_);
    ready.swap(waiting_);
  }
  for (const auto& work : ready) work(*simulator_);
}

ros::Time SteppedHost::stamp() const {
  return ros::Time(kStartTimeS + simulator_->time_s());
}

void SteppedHost::advance(double duration_s) {
  const auto steps = std::lround(duration_s / simulator_->params().bodies.step_s);
  for (long i = 0; i < steps; ++i) {
    run_posted();
    simulator_->step();
    ros::Time::setNow(stamp());
    for (const auto& publish : after_step_) publish(*simulator_, stamp());
  }
}

bool SteppedHost::advance_until(const std::function<bool()>& condition) {
  return wait_for([&] {
    if (condition()) return true;
    advance(0.02);
    return false;
  });
}

}  // namespace extperfc::ros_test
