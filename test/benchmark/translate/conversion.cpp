#include "test/benchmark/translate/conversion.hpp"

#include <filesystem>
#include <utility>

#include <ros/package.h>

#include "test/benchmark/translate/conversion_cases.hpp"

namespace extperfc::benchmark {

namespace {

constexpr char kGoalCase[] = "JointState";  // the goal is for a message of its size
constexpr double kGoalNs = 1'000.0;

}  // namespace

Result<std::vector<Row>> conversion_rows() {
  const std::filesystem::path package = ros::package::getPath("extperfc");
  const auto times = time_conversions(package / "config" / "translate");
  if (!times) return tl::unexpected(times.error());
  std::vector<Row> rows;
  for (const auto& time : *times) {
    const std::string name =
        "conversion: " + time.name + " (" + std::to_string(time.bytes_in) + " B, " + time.plan + ")";
    const Row row{name, "time, median", "ns", time.median_ns, time.memcpy_ns, "memcpy"};
    const bool has_goal = time.name.find(kGoalCase) != std::string::npos;
    rows.push_back(has_goal ? at_most(row, kGoalNs) : row);
    rows.push_back({name, "time, slowest batch", "ns", time.worst_ns});
  }
  return rows;
}

}  // namespace extperfc::benchmark
