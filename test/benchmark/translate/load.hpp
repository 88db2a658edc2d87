#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"
#include "test/benchmark/translate/options.hpp"
#include "test/benchmark/translate/stage.hpp"

namespace extperfc::benchmark {

/// Hundreds of topics at thousands of messages per second through the translator, then through the relay:
/// what arrives, when, and what it costs. This process must have joined the robot's master.
[[nodiscard]] Result<std::vector<Row>> load_rows(const Stage& stage, const TranslateOptions& options);

}  // namespace extperfc::benchmark
