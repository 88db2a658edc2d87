#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// The conversion of one message alone, in nanoseconds, for the cases of conversion_cases.hpp.
[[nodiscard]] Result<std::vector<Row>> conversion_rows();

}  // namespace extperfc::benchmark
