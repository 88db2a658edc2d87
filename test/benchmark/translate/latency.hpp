#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"
#include "test/benchmark/translate/options.hpp"
#include "test/benchmark/translate/stage.hpp"

namespace extperfc::benchmark {

/// One message at a time through every route from publisher to subscriber, in turns: latency, and CPU time of
/// the process in the middle. This process must have joined the robot's master.
[[nodiscard]] Result<std::vector<Row>> latency_rows(const Stage& stage, const TranslateOptions& options);

}  // namespace extperfc::benchmark
