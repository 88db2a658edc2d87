#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/random_world.hpp"
#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/simulator.hpp"

#include "ros/params/robot_interface_params.hpp"

namespace extperfc::ros_params {

/// How simulated time passes.
struct SimTimeParams {
  double real_time_factor{1.0};  ///< [0, 100]; 0: as fast as possible
  bool paused{false};            ///< at the start
  bool lockstep{false};          ///< the simulation waits for its sensors, so that no measurement is dropped
  double start_time_s{1.0};      ///< of the clock, [0.1, 1e9]: time 0 means "not set" to many nodes
  bool publish_clock{true};      ///< false for all but one of several simulations of one master
  double clock_hz{120.0};        ///< of /clock, per simulated second, [1, 2000]
};

struct BaseInterfaceParams {
  double odom_rate_hz{50.0};      ///< of odom and its tf, [1, 500]
  double imu_rate_hz{100.0};      ///< [1, 500]
  bool publish_odom_frame{true};  ///< tf odom -> base_footprint
  bool publish_map_frame{false};  ///< tf map -> odom from the truth, instead of a localizer's
};

struct CameraInterfaceParams {
  bool enabled{true};
  double rate_hz{15.0};                 ///< [0.1, 120]
  std::string depth_encoding{"16UC1"};  ///< 16UC1 [mm] or 32FC1 [m]
  int min_visible_px{40};               ///< of a box of sim/truth/detections
  simulate::CameraParams camera;
};

struct LidarInterfaceParams {
  bool enabled{true};
  simulate::LidarParams lidar;
};

/// Infrared in the hands, sonar around the head.
struct RangeInterfaceParams {
  bool enabled{true};
  double hand_rate_hz{50.0};   ///< [1, 200]
  double sonar_rate_hz{10.0};  ///< of the whole ring, [1, 50]
};

struct TruthParams {
  double odom_rate_hz{50.0};      ///< [0, 500]
  double objects_rate_hz{10.0};   ///< [0, 100]
  double markers_rate_hz{2.0};    ///< of what moves, [0, 30]
  double map_resolution_m{0.05};  ///< [0.01, 1]
  double map_min_z_m{0.1};        ///< the map shows what stands between these heights, [0, 3]
  double map_max_z_m{1.5};
  /// Class names in the order of their ids, as the detector's model has them; labels of the world that are
  /// not among them follow.
  std::vector<std::string> classes{"cone", "cube", "sphere"};
};

struct SimulatorNodeletParams {
  std::filesystem::path urdf;
  std::filesystem::path world;  ///< file; empty: a random world
  std::optional<simulate::RandomWorldParams> random_world;
  simulate::SimulatorParams simulator;
  SimTimeParams time;
  BaseInterfaceParams base;
  CameraInterfaceParams camera;
  LidarInterfaceParams lidar;
  RangeInterfaceParams range;
  TruthParams truth;
  RobotInterfaceParams robot;
  std::vector<simulate::Fault> faults;  ///< from the start
  std::filesystem::path people_file;    ///< people beside the world's; empty: none
};

/// Reads `private_handle`; every problem is reported at once.
[[nodiscard]] Result<SimulatorNodeletParams> load_simulator_params(const ros::NodeHandle& private_handle);

/// The file of a world: `name` as it is when it has a slash or ends in .yaml, otherwise
/// `<worlds>/<name>.yaml`. Error: no such file, with the names that there are.
[[nodiscard]] Result<std::filesystem::path> find_world(const std::string& name,
                                                       const std::filesystem::path& worlds);

/// The class names of the ground truth go to `<private>/classes`, the names of what a label image's
/// numbers mean to `<private>/instances`.
void store_truth_names(const ros::NodeHandle& private_handle, const std::vector<std::string>& classes,
                       const std::vector<std::string>& instances);

}  // namespace extperfc::ros_params
