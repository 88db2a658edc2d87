#include "test/benchmark/sim/core_cost.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/simulate/sensor_rig.hpp"
#include "extperfc/simulate/simulator.hpp"

namespace extperfc::benchmark {
namespace {

using simulate::Snapshot;

/// Median CPU time of this thread for one call [s].
double median_cpu_s(int times, const std::function<void(int)>& call) {
  std::vector<double> costs;
  for (int i = -3; i < times; ++i) {  // the first three warm up
    const CpuStopwatch watch;
    call(i);
    if (i >= 0) costs.push_back(watch.seconds());
  }
  std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2), costs.end());
  return costs[costs.size() / 2];
}

/// Arms wave, the base drives to and fro: nothing rests.
void keep_busy(simulate::Simulator& simulator) {
  const double phase = std::sin(simulator.time_s());
  simulator.command_base({0.1 * phase, 0.05 * phase, 0.1 * phase});
  for (const auto side : simulate::kSides) {
    simulate::ArmCommand command{simulate::ArmMode::kVelocity, {}};
    command.values.fill(0.2 * phase);
    (void)simulator.command_arm(side, command);
  }
}

Result<Row> physics_row(const Stage& stage, bool dynamic) {
  simulate::SimulatorParams params;
  params.start_enabled = true;
  params.bodies.dynamic = dynamic;
  auto simulator = simulate::Simulator::make(params, stage.robot, stage.world);
  if (!simulator) return tl::unexpected(simulator.error());
  const double cost = median_cpu_s(2400, [&](int) {
    keep_busy(**simulator);
    (*simulator)->step();
  });
  return Row{stage.world.name + ", physics " + (dynamic ? "dynamic" : "kinematic"),
             "step of 1/240 s, CPU",
             "us",
             cost * 1e6,
             params.bodies.step_s * 1e6,
             "real time"};
}

/// Snapshots of a moving robot, so that the sensors' tree is updated as in use.
Result<std::vector<Snapshot>> moving_snapshots(const Stage& stage, int count) {
  simulate::SimulatorParams params;
  params.start_enabled = true;
  auto simulator = simulate::Simulator::make(params, stage.robot, stage.world);
  if (!simulator) return tl::unexpected(simulator.error());
  std::vector<Snapshot> snapshots;
  for (int i = 0; i < count; ++i) {
    for (int step = 0; step < 16; ++step) {
      keep_busy(**simulator);
      (*simulator)->step();
    }
    snapshots.push_back((*simulator)->snapshot());
  }
  return snapshots;
}

Pose link_pose(const Stage& stage, const Snapshot& snapshot, const char* link) {
  return snapshot.world_T_link[static_cast<std::size_t>(stage.robot.link(link).value_or(0))];
}

std::vector<Row> camera_rows(const Stage& stage, simulate::SensorRig& rig,
                             const std::vector<Snapshot>& snapshots, int frames) {
  simulate::CameraImages images;
  const auto render = [&](const simulate::CameraParams& params) {
    return median_cpu_s(frames, [&](int i) {
      const auto& snapshot = snapshots[static_cast<std::size_t>(std::max(i, 0)) % snapshots.size()];
      rig.pose(snapshot);
      rig.camera(params, link_pose(stage, snapshot, "camera_color_optical_frame"), images);
    });
  };
  simulate::CameraParams params;
  const double soft = render(params);
  params.soft_light = false;
  const double hard = render(params);
  params.shadows = false;
  const double plain = render(params);
  const std::string name = stage.world.name + ", RGB-D 640x480";
  const double rays = 640.0 * 480.0;
  return {at_most(Row{name, "frame, hard shadows, CPU", "ms", hard * 1e3, 1e3 / 15, "15 Hz"}, 31.0),
          Row{name, "frame, soft light (the default), CPU", "ms", soft * 1e3, 1e3 / 15, "15 Hz"},
          Row{name, "frame without shadows, CPU", "ms", plain * 1e3, 1e3 / 15, "15 Hz"},
          Row{name, "primary rays, shaded, with noise", "Mrays/s", rays / plain * 1e-6}};
}

std::vector<Row> lidar_rows(const Stage& stage, simulate::SensorRig& rig,
                            const std::vector<Snapshot>& snapshots, int frames) {
  const simulate::LidarParams params;
  std::vector<simulate::LidarPoint> points;
  const double sweep = median_cpu_s(frames, [&](int i) {
    const auto& snapshot = snapshots[static_cast<std::size_t>(std::max(i, 0)) % snapshots.size()];
    rig.pose(snapshot);
    const Pose pose = link_pose(stage, snapshot, "velodyne");
    rig.lidar(params, pose, pose, points);
  });
  const std::string name = stage.world.name + ", VLP-16";
  return {at_most(Row{name, "sweep of 30,000 rays, CPU", "ms", sweep * 1e3, 1e3 / 10, "10 Hz"}, 3.0),
          Row{name, "rays", "Mrays/s", 16.0 * params.columns / sweep * 1e-6}};
}

}  // namespace

Result<Stage> load_stage(const std::string& package_folder, const std::string& world) {
  const std::filesystem::path root = package_folder;
  auto robot = RobotModel::from_file(root / "urdf" / "mobile_baxter.urdf", root);
  if (!robot) return tl::unexpected(robot.error());
  const bool is_file = world.find('/') != std::string::npos || world.find(".yaml") != std::string::npos;
  auto spec = simulate::load_world(is_file ? std::filesystem::path(world)
                                           : root / "config" / "worlds" / (world + ".yaml"));
  if (!spec) return tl::unexpected(spec.error());
  return Stage{std::move(*robot), std::move(*spec)};
}

Result<std::vector<Row>> core_rows(const Stage& stage, int frames) {
  std::vector<Row> rows;
  for (const bool dynamic : {false, true}) {
    auto row = physics_row(stage, dynamic);
    if (!row) return tl::unexpected(row.error());
    rows.push_back(*row);
  }
  const auto snapshots = moving_snapshots(stage, 30);
  if (!snapshots) return tl::unexpected(snapshots.error());
  auto rig = simulate::SensorRig::make(stage.robot, stage.world, 1);
  if (!rig) return tl::unexpected(rig.error());
  std::printf("%zu triangles, rays by %s\n", (*rig)->triangles(), (*rig)->engine());
  for (const auto& row : camera_rows(stage, **rig, *snapshots, frames)) rows.push_back(row);
  for (const auto& row : lidar_rows(stage, **rig, *snapshots, frames)) rows.push_back(row);
  return rows;
}

}  // namespace extperfc::benchmark
