#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Collision checks of Baxter's two arms before a shelf with 15 objects: states per second of the spheres and
/// of Bullet, time of proving a motion of 0.5 rad, states that the spheres call free and Bullet does not. CPU
/// times of the thread. `quick`: a twentieth of the states.
[[nodiscard]] Result<std::vector<Row>> collision_rows(bool quick);

}  // namespace extperfc::benchmark
