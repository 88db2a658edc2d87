#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/simulator.hpp"

#include "ros/simulate/sim_thread.hpp"

namespace extperfc::ros_simulate {

/// Sets faults and carries out the two that the simulator itself cannot: a clock that jumps and a process
/// that dies. Everything runs in the simulation thread.
class FaultControl {
 public:
  /// `at_start`: faults that are active from the start and after every reset.
  FaultControl(SimThread& thread, std::vector<simulate::Fault> at_start)
      : thread_(thread), at_start_(std::move(at_start)) {}

  [[nodiscard]] Result<void> set(simulate::Simulator& simulator, const simulate::Fault& fault);
  /// The simulator is at its start: sets what is active from there. Every error at once.
  [[nodiscard]] Result<void> begin(simulate::Simulator& simulator);

  /// Call after every step: ends the process with exit code 1 when a fault `die` is due.
  void die_when_due(const simulate::Simulator& simulator) const;

 private:
  SimThread& thread_;
  const std::vector<simulate::Fault> at_start_;
  std::optional<double> dies_at_s_;  ///< simulated time
};

/// "lidar_rings 3,7", "camera_drop 0.5 for 2 s": for people.
[[nodiscard]] std::string describe(const simulate::Fault& fault);

}  // namespace extperfc::ros_simulate
