#pragma once

#include <memory>

#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render/ray_scene.hpp"

namespace extperfc::simulate::render {

/// A rig over the given engine; SensorRig::make() takes the fastest.
[[nodiscard]] Result<std::unique_ptr<SensorRig>> make_rig(const RobotModel& robot, const WorldSpec& world,
                                                          std::uint64_t seed,
                                                          std::unique_ptr<RayScene> engine);

}  // namespace extperfc::simulate::render
