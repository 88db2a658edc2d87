#include "ros/robot/complaints.hpp"

#include <utility>

#include <ros/console.h>

namespace extperfc::ros_robot {

Complaints::Complaints(std::function<void(const std::string&)> log) : log_(std::move(log)) {
  if (!log_) log_ = [](const std::string& line) { ROS_ERROR("%s", line.c_str()); };
}

void Complaints::report(const std::string& message, Clock::time_point now) {
  std::string line = message;
  {
    const std::lock_guard lock(mutex_);
    if (last_ && now - *last_ < std::chrono::seconds(1)) {
      ++left_out_;
      return;
    }
    last_ = now;
    if (left_out_ > 0) line += " (and " + std::to_string(left_out_) + " like it)";
    left_out_ = 0;
  }
  log_(line);
}

}  // namespace extperfc::ros_robot
