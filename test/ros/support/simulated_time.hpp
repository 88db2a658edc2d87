#pragma once

#include <ros/time.h>

namespace extperfc::ros_test {

/// Time of the process as a clock would set it [s]; real time again at the end.
class SimulatedTime {
 public:
  explicit SimulatedTime(double seconds) { set(seconds); }
  ~SimulatedTime() { ros::Time::init(); }
  SimulatedTime(const SimulatedTime&) = delete;
  SimulatedTime& operator=(const SimulatedTime&) = delete;
  static void set(double seconds) { ros::Time::setNow(ros::Time(seconds)); }
};

}  // namespace extperfc::ros_test
