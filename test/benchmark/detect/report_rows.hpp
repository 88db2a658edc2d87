#pragma once

#include <string>
#include <utility>
#include <vector>

#include "test/benchmark/detect/measure.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

using MeasuredCase = std::pair<DetectCase, DetectFigures>;

/// What the nodelets may add to bare inference [ms]: 10 % or 2 ms, whichever is larger.
[[nodiscard]] double overhead_goal_ms(double bare_ms);

/// Everything, for the JSON file.
[[nodiscard]] std::vector<Row> rows_of(const std::vector<MeasuredCase>& cases);

/// Where the time of one frame goes, two lines per case.
void print_breakdown(const std::vector<MeasuredCase>& cases);

}  // namespace extperfc::benchmark
