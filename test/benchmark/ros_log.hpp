#pragma once

#include <ros/console.h>

namespace extperfc::benchmark {

/// Whoever measures hears only what is wrong.
inline void log_warnings_only() {
  if (ros::console::set_logger_level(ROSCONSOLE_ROOT_LOGGER_NAME, ros::console::levels::Warn))
    ros::console::notifyLoggerLevelsChanged();
}

}  // namespace extperfc::benchmark
