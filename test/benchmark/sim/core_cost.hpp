#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/robot_model.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// What the simulator is made of.
struct Stage {
  RobotModel robot;
  simulate::WorldSpec world;
};

/// The robot of the package in a world of config/worlds, or of a file.
[[nodiscard]] Result<Stage> load_stage(const std::string& package_folder, const std::string& world);

/// CPU time of a step of the physics, a camera frame and a lidar sweep, each alone on one thread.
[[nodiscard]] Result<std::vector<Row>> core_rows(const Stage& stage, int frames);

}  // namespace extperfc::benchmark
