#pragma once

#include <optional>
#include <string>

#include "test/benchmark/localize/subject.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {

/// A row with both sides; `peer` may be missing.
[[nodiscard]] inline Row both(const std::string& name, const std::string& metric, const std::string& unit,
                              double ours, std::optional<double> peer) {
  Row row{name, metric, unit, ours};
  if (peer) {
    row.peer = peer;
    row.peer_name = kPeerName;
  }
  return row;
}

}  // namespace extperfc::benchmark
