#include "ros/params/simulator_params.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <ros/package.h>

#include "ros/params/group_reader.hpp"
#include "ros/params/list_reader.hpp"

namespace extperfc::ros_params {

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 9> kGroups{"random_world", "time",  "physics", "base", "arms",
                                             "camera",       "lidar", "range",   "truth"};

Result<void> set_fault(simulate::Fault& fault, const std::string& key, const Entry& entry) {
  constexpr Range<double> kAny{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};
  if (key == "kind") {
    const auto kind = simulate::fault_kind(entry.text());
    if (!kind) return fail(ErrorCode::kInvalidArgument, "unknown kind '" + entry.text() + "'");
    fault.kind = *kind;
    return {};
  }
  if (key == "target") {
    fault.target = entry.text();
    return {};
  }
  if (key != "value" && key != "duration_s")
    return fail(ErrorCode::kInvalidArgument, "unknown key; a fault has kind, target, value, duration_s");
  const auto number = entry.number(kAny);
  if (!number) return tl::unexpected(number.error());
  (key == "value" ? fault.value : fault.duration_s) = *number;
  return {};
}

void read_robot_and_world(ParamReader& reader, SimulatorNodeletParams& params) {
  const fs::path package = ros::package::getPath("extperfc");
  std::string urdf = package / "urdf" / "mobile_baxter.urdf";
  std::string world = "lab";
  int seed = 1;
  reader.read("urdf", urdf);
  reader.read("world", world);
  reader.read("seed", seed, {0, 2147483647});
  std::string people_file;
  reader.read("people_file", people_file);
  params.people_file = people_file;
  reader.read("start_enabled", params.simulator.start_enabled);
  params.urdf = urdf;
  params.simulator.seed = static_cast<std::uint64_t>(seed);
  using Kind = simulate::RandomWorldParams::Kind;
  if (world == "random_table" || world == "random_floor") {
    params.random_world.emplace().kind = world == "random_table" ? Kind::kTable : Kind::kFloor;
    return;
  }
  if (auto file = find_world(world, package / "config" / "worlds")) {
    params.world = *file;
  } else {
    reader.complain(file.error().message);
  }
}

void read_random_world(ParamReader& reader, std::optional<simulate::RandomWorldParams>& params) {
  double person = simulate::RandomWorldParams().person;
  reader.read("person", person, {0.0, 1.0});
  if (params) params->person = person;
}

void read_time(ParamReader& reader, SimTimeParams& params) {
  reader.read("real_time_factor", params.real_time_factor, {0.0, 100.0});
  reader.read("paused", params.paused);
  reader.read("lockstep", params.lockstep);
  reader.read("start_time_s", params.start_time_s, {0.1, 1e9});
  reader.read("publish_clock", params.publish_clock);
  reader.read("clock_hz", params.clock_hz, {1.0, 2000.0});
}

void read_physics(ParamReader& reader, simulate::BodiesParams& params) {
  double step_hz = std::round(1.0 / params.step_s);
  reader.read("step_hz", step_hz, {100.0, 2000.0});
  reader.read("dynamic", params.dynamic);
  reader.read("solver_iterations", params.solver_iterations, {10, 500});
  reader.read("gravity_m_s2", params.gravity_m_s2, {0.0, 20.0});
  reader.read("hold_gripped", params.hold_gripped);
  params.step_s = 1.0 / step_hz;
}

void read_base(ParamReader& reader, simulate::BaseParams& base, BaseInterfaceParams& interface) {
  reader.read("max_speed_m_s", base.max_speed_m_s, {0.01, 1.84});
  reader.read("max_yaw_rate_rad_s", base.max_yaw_rate_rad_s, {0.01, 3.1});
  reader.read("max_accel_m_s2", base.max_accel_m_s2, {0.01, 4.0});
  reader.read("max_yaw_accel_rad_s2", base.max_yaw_accel_rad_s2, {0.01, 9.5});
  reader.read("command_timeout_s", base.command_timeout_s, {0.01, 5.0});
  reader.read("wheel_noise", base.wheel_noise, {0.0, 0.5});
  reader.read("wheel_slip", base.wheel_slip, {0.0, 0.5});
  reader.read("lateral_slip", base.lateral_slip, {0.0, 0.5});
  reader.read("gyro_noise_rad_s", base.gyro_noise_rad_s, {0.0, 1.0});
  reader.read("gyro_bias_rad_s", base.gyro_bias_rad_s, {0.0, 1.0});
  reader.read("accel_noise_m_s2", base.accel_noise_m_s2, {0.0, 10.0});
  reader.read("odom_rate_hz", interface.odom_rate_hz, {1.0, 500.0});
  reader.read("imu_rate_hz", interface.imu_rate_hz, {1.0, 500.0});
  reader.read("publish_odom_frame", interface.publish_odom_frame);
  reader.read("publish_map_frame", interface.publish_map_frame);
}

void read_arms(ParamReader& reader, simulate::ArmParams& params) {
  reader.read("max_accel_rad_s2", params.max_accel_rad_s2, {0.1, 50.0});
  reader.read("command_timeout_s", params.command_timeout_s, {0.01, 1.0});
  reader.read("start_pose", params.start_pose);
  const std::array<const char*, 3> poses{"untuck", "tuck", "neutral"};
  if (std::find(poses.begin(), poses.end(), params.start_pose) == poses.end())
    reader.complain("arms/start_pose '" + params.start_pose + "' is unknown: use untuck, tuck or neutral");
}

void read_depth_noise(ParamReader& reader, simulate::DepthNoiseParams& depth) {
  reader.read("min_depth_m", depth.min_depth_m, {0.0, 10.0});
  reader.read("max_depth_m", depth.max_depth_m, {0.1, 65.0});
  reader.read("depth_focal_px", depth.focal_px, {10.0, 10000.0});
  reader.read("depth_baseline_m", depth.baseline_m, {0.001, 1.0});
  reader.read("depth_subpixel_px", depth.subpixel_px, {0.0, 2.0});
  reader.read("depth_quantum_m", depth.quantum_m, {0.0001, 0.1});
  reader.read("depth_hole_probability", depth.hole_probability, {0.0, 1.0});
  reader.read("depth_edge_holes", depth.edge_holes, {0.0, 1.0});
  if (depth.min_depth_m >= depth.max_depth_m) reader.complain("camera/min_depth_m must be below max_depth_m");
}

void read_camera(ParamReader& reader, CameraInterfaceParams& params) {
  CameraModel& model = params.camera.model;
  double focal_px = 0.0;
  reader.read("enabled", params.enabled);
  reader.read("rate_hz", params.rate_hz, {0.1, 120.0});
  reader.read("depth_encoding", params.depth_encoding);
  reader.read("min_visible_px", params.min_visible_px, {1, 1000000});
  reader.read("width", model.width, {16, 4096});
  reader.read("height", model.height, {16, 4096});
  reader.read("focal_px", focal_px, {0.0, 1e5});
  reader.read("shadows", params.camera.shadows);
  reader.read("soft_light", params.camera.soft_light);
  reader.read("supersampling", params.camera.supersampling, {1, 2});
  reader.read("image_noise", params.camera.image_noise, {0.0, 1.0});
  read_depth_noise(reader, params.camera.depth);
  constexpr double kD435iFocalPx = 615.0;  // of the colour image, at 640 pixels width
  model.fx = model.fy = focal_px > 0.0 ? focal_px : kD435iFocalPx * model.width / 640.0;
  model.cx = 0.5 * (model.width - 1);
  model.cy = 0.5 * (model.height - 1);
  if (params.depth_encoding != "16UC1" && params.depth_encoding != "32FC1")
    reader.complain("camera/depth_encoding '" + params.depth_encoding + "' is unknown: use 16UC1 or 32FC1");
}

void read_lidar(ParamReader& reader, LidarInterfaceParams& params) {
  constexpr double kColumnsPerSecond = 18750.0;  // 300,000 points of 16 rings
  simulate::LidarParams& lidar = params.lidar;
  int columns = 0;
  reader.read("enabled", params.enabled);
  reader.read("rotation_hz", lidar.rotation_hz, {5.0, 20.0});
  reader.read("columns", columns, {0, 3750});
  reader.read("min_range_m", lidar.min_range_m, {0.0, 10.0});
  reader.read("max_range_m", lidar.max_range_m, {1.0, 200.0});
  reader.read("range_noise_m", lidar.range_noise_m, {0.0, 1.0});
  reader.read("quantum_m", lidar.quantum_m, {0.0001, 0.1});
  reader.read("drop_probability", lidar.drop_probability, {0.0, 1.0});
  lidar.columns =
      columns > 0 ? columns : static_cast<int>(std::lround(kColumnsPerSecond / lidar.rotation_hz));
  if (lidar.min_range_m >= lidar.max_range_m) reader.complain("lidar/min_range_m must be below max_range_m");
}

void read_range(ParamReader& reader, RangeInterfaceParams& params) {
  reader.read("enabled", params.enabled);
  reader.read("hand_rate_hz", params.hand_rate_hz, {1.0, 200.0});
  reader.read("sonar_rate_hz", params.sonar_rate_hz, {1.0, 50.0});
}

void read_truth(ParamReader& reader, const ros::NodeHandle& handle, TruthParams& params) {
  reader.read("odom_rate_hz", params.odom_rate_hz, {0.0, 500.0});
  reader.read("objects_rate_hz", params.objects_rate_hz, {0.0, 100.0});
  reader.read("markers_rate_hz", params.markers_rate_hz, {0.0, 30.0});
  reader.read("map_resolution_m", params.map_resolution_m, {0.01, 1.0});
  reader.read("map_min_z_m", params.map_min_z_m, {0.0, 3.0});
  reader.read("map_max_z_m", params.map_max_z_m, {0.0, 3.0});
  if (params.map_min_z_m >= params.map_max_z_m)
    reader.complain("truth/map_min_z_m must be below map_max_z_m");
  read_strings(reader, handle, "classes", params.classes);
}

}  // namespace

Result<SimulatorNodeletParams> load_simulator_params(const ros::NodeHandle& private_handle) {
  SimulatorNodeletParams params;
  GroupReader groups(private_handle);
  groups.group("", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    for (const char* group : kGroups) reader.accept(group);
    for (const char* written : {"classes", "instances"}) reader.accept(written);
    reader.accept("robot");  // load_robot_interface_params reads it
    read_robot_and_world(reader, params);
    params.faults = read_list<simulate::Fault>(reader, handle, "faults", set_fault);
  });
  groups.group("random_world", [&](ParamReader& reader, const ros::NodeHandle&) {
    read_random_world(reader, params.random_world);
  });
  groups.group("time", [&](ParamReader& reader, const ros::NodeHandle&) { read_time(reader, params.time); });
  groups.group("physics", [&](ParamReader& reader, const ros::NodeHandle&) {
    read_physics(reader, params.simulator.bodies);
  });
  groups.group("base", [&](ParamReader& reader, const ros::NodeHandle&) {
    read_base(reader, params.simulator.base, params.base);
  });
  groups.group(
      "arms", [&](ParamReader& reader, const ros::NodeHandle&) { read_arms(reader, params.simulator.arms); });
  groups.group("camera",
               [&](ParamReader& reader, const ros::NodeHandle&) { read_camera(reader, params.camera); });
  groups.group("lidar",
               [&](ParamReader& reader, const ros::NodeHandle&) { read_lidar(reader, params.lidar); });
  groups.group("range",
               [&](ParamReader& reader, const ros::NodeHandle&) { read_range(reader, params.range); });
  groups.group("truth", [&](ParamReader& reader, const ros::NodeHandle& handle) {
    read_truth(reader, handle, params.truth);
  });
  if (auto robot = load_robot_interface_params(private_handle)) {
    params.robot = *robot;
  } else {
    groups.complain(robot.error().message);
  }
  if (auto finished = groups.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

Result<fs::path> find_world(const std::string& name, const fs::path& worlds) {
  const bool is_file = name.find('/') != std::string::npos || fs::path(name).extension() == ".yaml";
  const fs::path file = is_file ? fs::path(name) : worlds / (name + ".yaml");
  std::error_code ignored;
  if (fs::is_regular_file(file, ignored)) return file;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(worlds, ignored))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  std::sort(names.begin(), names.end());
  std::string known;
  for (const auto& one : names) known += one + ", ";
  return fail(ErrorCode::kNotFound, "there is no world '" + name + "': " + file.string() +
                                        " does not exist; use a file or one of: " + known +
                                        "random_table, random_floor");
}

void store_truth_names(const ros::NodeHandle& private_handle, const std::vector<std::string>& classes,
                       const std::vector<std::string>& instances) {
  private_handle.setParam("classes", classes);
  private_handle.setParam("instances", instances);
}

}  // namespace extperfc::ros_params
