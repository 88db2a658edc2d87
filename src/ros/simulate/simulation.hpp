#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/simulator.hpp"

#include "ros/params/simulator_params.hpp"
#include "ros/robot/robot_interface.hpp"
#include "ros/simulate/base_interface.hpp"
#include "ros/simulate/fault_control.hpp"
#include "ros/simulate/sensor_worker.hpp"
#include "ros/simulate/sim_services.hpp"
#include "ros/simulate/sim_thread.hpp"
#include "ros/simulate/truth_publisher.hpp"

namespace extperfc::ros_simulate {

/// Everything that extperfc/simulator is made of, put together.
class Simulation {
 public:
  using Report = std::function<void(diagnostic_updater::DiagnosticStatusWrapper&)>;

  /// Errors: a robot or world that cannot be read, a frame that the robot lacks, an invalid fault.
  [[nodiscard]] static Result<std::unique_ptr<Simulation>> make(
      const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
      const ros_params::SimulatorNodeletParams& params);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  void start() { thread_->start(); }
  /// World, robot and engines in a line.
  [[nodiscard]] const std::string& description() const { return description_; }
  /// Name and report of each part, for diagnostics.
  [[nodiscard]] std::vector<std::pair<std::string, Report>> reports();

 private:
  Simulation() = default;
  [[nodiscard]] Result<void> build(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                                   const ros_params::SimulatorNodeletParams& params,
                                   std::unique_ptr<simulate::Simulator> simulator,
                                   const TruthClasses& classes);
  void report_time(diagnostic_updater::DiagnosticStatusWrapper& status) const;

  std::string description_;
  std::unique_ptr<SensorWorker> sensors_;  ///< outlives the thread, which waits for it
  std::unique_ptr<SimThread> thread_;
  std::unique_ptr<FaultControl> faults_;
  std::unique_ptr<ros_robot::RobotInterface> robot_;
  std::unique_ptr<BaseInterface> base_;
  std::unique_ptr<TruthPublisher> truth_;
  std::unique_ptr<SimServices> services_;
};

}  // namespace extperfc::ros_simulate
