#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

struct PlanOptions {
  bool quick{false};
  std::string floors;              ///< office, hall, maze, map or growth; empty: all
  std::filesystem::path real_map;  ///< map_server's YAML; empty: none
};

/// Global planning: time, length against exact shortest paths, growth with the map, footprints.
void measure_plans(const PlanOptions& options, std::vector<Row>& rows);

}  // namespace extperfc::benchmark
