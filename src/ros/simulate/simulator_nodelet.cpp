#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "ros/health/reporter.hpp"
#include "ros/params/simulator_params.hpp"
#include "ros/simulate/simulation.hpp"

namespace extperfc::ros_simulate {

/// A mobile Baxter in a simulated world, with the topics, services, actions and frames of the real one.
///
/// Publishes:
///   diagnostics  diagnostic_msgs/DiagnosticArray
/// Parts: SimThread, SimServices, BaseInterface, CameraSensor, LidarSensor, HandRangeSensor, SonarSensor,
///   TruthPublisher, RobotInterface
/// Parameters: config/simulator.yaml, and the group `robot` in config/robot_interface.yaml. The nodelet
///   writes the names of class ids and of the numbers in the label image to the parameters `classes` and
///   `instances`.
/// Frames: odom -> base_footprint, and map -> odom when base/publish_map_frame is set; the robot's own frames
///   come from robot_state_publisher. The world's frame is map.
/// Diagnostics: one status for the simulation (real-time factor, steps), the base and each sensor (rate, work
///   and CPU time of a frame, replaced and lost frames).
/// Threads: one steps the simulation and publishes what the robot's controllers would; one measures for the
///   sensors; two answer the services of the simulation.
class SimulatorNodelet : public nodelet::Nodelet {
  void onInit() override;
  void add_diagnostics();

  std::unique_ptr<Simulation> simulation_;
  std::optional<ros_health::Reporter> reporter_;  ///< last: it asks the simulation
};

void SimulatorNodelet::onInit() {
  auto params = ros_params::load_simulator_params(getPrivateNodeHandle());
  auto simulation = params ? Simulation::make(getNodeHandle(), getPrivateNodeHandle(), *params)
                           : tl::unexpected(params.error());
  if (!simulation) {
    NODELET_FATAL("%s", simulation.error().message.c_str());
    throw std::runtime_error(simulation.error().message);
  }
  simulation_ = std::move(*simulation);
  NODELET_INFO("%s", simulation_->description().c_str());
  add_diagnostics();
  simulation_->start();
}

void SimulatorNodelet::add_diagnostics() {
  reporter_.emplace(getNodeHandle(), getPrivateNodeHandle(), getName(), "simulated");
  for (const auto& [name, report] : simulation_->reports()) reporter_->add(name, report);
  reporter_->start();
}

}  // namespace extperfc::ros_simulate

PLUGINLIB_EXPORT_CLASS(extperfc::ros_simulate::SimulatorNodelet, nodelet::Nodelet)
