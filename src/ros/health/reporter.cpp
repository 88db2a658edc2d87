#include "ros/health/reporter.hpp"

#include <algorithm>

namespace extperfc::ros_health {

namespace {

constexpr double kFirstReportS = 0.1;
constexpr double kShortestPeriodS = 0.01;
constexpr bool kOnce = false;
constexpr bool kAtOnce = false;  ///< start() begins

}  // namespace

Reporter::Reporter(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                   const std::string& name, const std::string& hardware_id)
    : updater_(handle, private_handle, name),
      timer_(handle.createWallTimer(
          ros::WallDuration(kFirstReportS), [this](const ros::WallTimerEvent&) { report(); }, kOnce,
          kAtOnce)) {
  updater_.setHardwareID(hardware_id);
}

Reporter::~Reporter() {
  timer_.stop();  // waits for a report that runs
}

void Reporter::report() {
  updater_.force_update();  // reads the period again
  timer_.setPeriod(ros::WallDuration(std::max(kShortestPeriodS, updater_.getPeriod())), false);
}

}  // namespace extperfc::ros_health
