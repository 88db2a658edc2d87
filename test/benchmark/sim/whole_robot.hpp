#pragma once

#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// Sets what must be set before the first node handle: nodes shall follow /clock.
void use_simulated_time();

/// The nodelet `simulator` in this process, as in a nodelet manager: how fast it runs and what it costs with
/// every sensor subscribed and with none. Errors: it does not start, or no sensor sends anything.
[[nodiscard]] Result<std::vector<Row>> whole_robot_rows(const std::string& world, double seconds);

}  // namespace extperfc::benchmark
