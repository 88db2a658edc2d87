#pragma once

#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/options.hpp"
#include "test/benchmark/map/subjects.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Every subject as another robot might have recorded it: with a poorer scanner, worse wheels, missing scans,
/// driven backwards. Errors as of the log itself; seed 1.
[[nodiscard]] Result<std::vector<Row>> varied_rows(const std::vector<Subject>& subjects);

}  // namespace extperfc::benchmark
