#include "ros/simulate/simulation.hpp"

#include "extperfc/simulate/random_world.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/robot_model.hpp"

#include "ros/simulate/camera_sensor.hpp"
#include "ros/simulate/lidar_sensor.hpp"
#include "ros/simulate/range_sensors.hpp"
#include "ros/simulate/truth_classes.hpp"

namespace extperfc::ros_simulate {

namespace {

using ros_params::SimulatorNodeletParams;
using Sensors = std::vector<std::unique_ptr<Sensor>>;

/// Adds a sensor, or its error to `problems`.
template <typename T>
void add(Sensors& sensors, Result<std::unique_ptr<T>> made, std::string& problems) {
  if (made) {
    sensors.push_back(std::move(*made));
  } else {
    problems += (problems.empty() ? "" : "\n  ") + made.error().message;
  }
}

Result<Sensors> make_sensors(const ros::NodeHandle& handle, const SimulatorNodeletParams& params,
                             const RobotModel& robot, const TruthClasses& classes) {
  Sensors sensors;
  std::string problems;
  const auto seed = params.simulator.seed;
  if (params.camera.enabled)
    add(sensors, CameraSensor::make(handle, params.camera, robot, seed, classes), problems);
  if (params.lidar.enabled) add(sensors, LidarSensor::make(handle, params.lidar, robot, seed), problems);
  if (params.range.enabled) {
    for (const auto side : simulate::kSides)
      add(sensors, HandRangeSensor::make(handle, params.range.hand_rate_hz, side, robot), problems);
    add(sensors, SonarSensor::make(handle, params.range.sonar_rate_hz, robot), problems);
  }
  if (!problems.empty()) return fail(ErrorCode::kNotFound, problems);
  return sensors;
}

Result<simulate::WorldSpec> make_world(const SimulatorNodeletParams& params) {
  auto world = params.random_world ? simulate::random_world(*params.random_world, params.simulator.seed)
                                   : simulate::load_world(params.world);
  if (!world || params.people_file.empty()) return world;
  return simulate::with_people(std::move(*world), params.people_file);
}

std::vector<std::string> names_of(const std::vector<simulate::Instance>& instances) {
  std::vector<std::string> names;
  names.reserve(instances.size());
  for (const auto& instance : instances) names.push_back(instance.name);
  return names;
}

std::string describe(const simulate::Simulator& simulator, const simulate::SensorRig& rig) {
  const auto& world = simulator.world();
  const bool dynamic = simulator.params().bodies.dynamic;
  return "world " + world.name + ": " + std::to_string(world.bodies.size()) + " bodies, " +
         std::to_string(world.people.size()) + " people, " + std::to_string(rig.triangles()) +
         " triangles; arms " + (dynamic ? "dynamic" : "kinematic") + "; rays by " + rig.engine();
}

}  // namespace

Result<std::unique_ptr<Simulation>> Simulation::make(const ros::NodeHandle& handle,
                                                     const ros::NodeHandle& private_handle,
                                                     const SimulatorNodeletParams& params) {
  auto robot = RobotModel::from_file(params.urdf, params.urdf.parent_path().parent_path());
  if (!robot) return tl::unexpected(robot.error());
  auto world = make_world(params);
  if (!world) return tl::unexpected(world.error());
  auto rig = simulate::SensorRig::make(*robot, *world, params.simulator.seed);
  if (!rig) return tl::unexpected(rig.error());
  auto simulator = simulate::Simulator::make(params.simulator, *robot, *world);
  if (!simulator) return tl::unexpected(simulator.error());
  const TruthClasses classes(params.truth.classes, *world);
  auto sensors = make_sensors(handle, params, *robot, classes);
  if (!sensors) return tl::unexpected(sensors.error());
  auto made = std::unique_ptr<Simulation>(new Simulation);
  made->description_ = describe(**simulator, **rig);
  ros_params::store_truth_names(private_handle, classes.names(), names_of((*rig)->instances()));
  made->sensors_ = std::make_unique<SensorWorker>(std::move(*rig), std::move(*sensors));
  if (auto built = made->build(handle, private_handle, params, std::move(*simulator), classes); !built)
    return tl::unexpected(built.error());
  return made;
}

Result<void> Simulation::build(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle,
                               const SimulatorNodeletParams& params,
                               std::unique_ptr<simulate::Simulator> simulator, const TruthClasses& classes) {
  simulate::Simulator& present = *simulator;
  thread_ = std::make_unique<SimThread>(handle, params.time, std::move(simulator));
  faults_ = std::make_unique<FaultControl>(*thread_, params.faults);
  if (auto begun = faults_->begin(present); !begun) return begun;
  robot_ = std::make_unique<ros_robot::RobotInterface>(handle, *thread_, params.robot);
  base_ = std::make_unique<BaseInterface>(handle, *thread_, params.base, params.simulator.base);
  truth_ = std::make_unique<TruthPublisher>(handle, private_handle, *thread_, params.truth, present.world(),
                                            classes);
  if (auto map = truth_->publish_map(present.world(), params.truth); !map) return map;
  services_ = std::make_unique<SimServices>(handle, *thread_, *faults_);
  thread_->after_step([this](const simulate::Simulator& stepped, const ros::Time& stamp) {
    sensors_->after_step(stepped, stamp);
    faults_->die_when_due(stepped);
  });
  thread_->when_settling([this] { sensors_->wait_until_idle(); });
  return {};
}

/// Commands end first, then the thread, then what it calls.
Simulation::~Simulation() {
  if (base_) base_->shutdown();
  if (thread_) thread_->stop();
}

std::vector<std::pair<std::string, Simulation::Report>> Simulation::reports() {
  std::vector<std::pair<std::string, Report>> all;
  all.emplace_back("simulation", [this](auto& status) { report_time(status); });
  all.emplace_back("base", [this](auto& status) { base_->report(status); });
  for (std::size_t i = 0; i < sensors_->size(); ++i)
    all.emplace_back(sensors_->name(i), [this, i](auto& status) { sensors_->report(i, status); });
  return all;
}

void Simulation::report_time(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  const auto now = thread_->status();
  constexpr double kNearlyEnough = 0.9;
  status.summary(diagnostic_msgs::DiagnosticStatus::OK, now.paused ? "paused" : "running");
  if (!now.paused && now.measured_factor > 0 && now.measured_factor < kNearlyEnough * now.wanted_factor)
    status.mergeSummaryf(diagnostic_msgs::DiagnosticStatus::WARN,
                         "slower than wanted: %.2f instead of %.2f; use a smaller world, fewer or slower "
                         "sensors, or a lower factor",
                         now.measured_factor, now.wanted_factor);
  status.add("world", description_);
  status.addf("real-time factor", "%.3f", now.measured_factor);
  status.addf("wanted factor", "%.3f", now.wanted_factor);
  status.addf("simulated [s]", "%.3f", now.simulated_s);
  status.add("steps", now.steps);
  status.add("debts dropped", now.debts_dropped);
}

}  // namespace extperfc::ros_simulate
