#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <ros/time.h>

#include "extperfc/simulate/robot_io.hpp"
#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/simulator.hpp"

namespace extperfc::ros_simulate {

/// What a sensor needs to measure once, after the simulation has gone on.
struct SensorJob {
  ros::Time stamp;                                   ///< of `now`
  std::shared_ptr<const simulate::Snapshot> before;  ///< when the sensor was due last; null: not known
  std::shared_ptr<const simulate::Snapshot> now;
  std::vector<simulate::Fault> faults;  ///< active now
};

/// One sensor: whether it has subscribers, and how it measures and publishes.
class Sensor {
 public:
  virtual ~Sensor() = default;
  [[nodiscard]] virtual const char* name() const = 0;
  [[nodiscard]] virtual double rate_hz() const = 0;
  /// Any thread.
  [[nodiscard]] virtual bool wanted() const = 0;
  /// Worker thread only. The rig's scene is as in `job.now`. True when something was published.
  virtual bool measure(simulate::SensorRig& rig, const SensorJob& job) = 0;
  /// Where what was published last lies in memory, for diagnostics; any thread.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::string>> details() const { return {}; }
};

}  // namespace extperfc::ros_simulate
