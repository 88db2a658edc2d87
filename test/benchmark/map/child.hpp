#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::benchmark {

/// Named numbers, which a part of this program prints as lines `name value`. Names hold no blanks.
using Figures = std::map<std::string, double>;

/// NaN where there is none of this name.
[[nodiscard]] double figure_of(const Figures& figures, const std::string& name);

/// What became of a program that has ended.
struct ChildRun {
  double cpu_s{0};           ///< of all its threads
  double peak_memory_mb{0};  ///< its largest resident memory [10^6 bytes], not below this program's own
  bool out_of_cpu{false};    ///< the limit ended it
};

/// Runs a program to its end, or until it has used `max_cpu_s` of CPU (0: without a limit); both its outputs
/// go to a file. Errors: it cannot be started, or it failed: then with the end of what it said.
[[nodiscard]] Result<ChildRun> run_program(const std::vector<std::string>& tokens,
                                           const std::filesystem::path& output, unsigned max_cpu_s = 0);

/// Runs this program again as `--part tokens...`, alone in a separate process, and reads its figures.
[[nodiscard]] Result<Figures> run_part(const std::vector<std::string>& tokens);

/// The file of a program that was built beside this one.
[[nodiscard]] std::filesystem::path beside_this_program(const std::string& name);

}  // namespace extperfc::benchmark
