#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

/// The time of one conversion alone: no sockets, output memory that is used again.
struct ConversionTime {
  std::string name;
  std::string plan;  ///< "pass" or "convert"
  std::size_t bytes_in{0};
  std::size_t bytes_out{0};
  double median_ns{0};
  double worst_ns{0};   ///< of the batches, a batch being many conversions
  double memcpy_ns{0};  ///< median of copying bytes_in to the same memory, in turns with the conversions
};

/// Converts messages like those of a Baxter and of MoveIt. `config` is the folder config/translate with the
/// shipped definitions and rules; an error says which of them is missing. Takes about a second.
[[nodiscard]] Result<std::vector<ConversionTime>> time_conversions(const std::filesystem::path& config);

}  // namespace extperfc::benchmark
