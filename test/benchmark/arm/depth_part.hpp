#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// What a depth image of 640 x 480 pixels costs as an obstacle (CPU time): a table with objects on it and
/// both arms before the camera of the head; and what the boxes cost in collision checks of both arms.
/// `quick`: fewer runs.
[[nodiscard]] Result<std::vector<Row>> depth_rows(bool quick);

}  // namespace extperfc::benchmark
