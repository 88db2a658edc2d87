#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

#include "test/benchmark/map/drive.hpp"

namespace extperfc::benchmark {

/// Largest mean errors of the relations, for every seed.
struct AccuracyGoals {
  double translation_m{0};
  double rotation_deg{0};
};

/// A recording that is mapped.
struct Subject {
  std::string name;
  Recording recording;
  std::optional<AccuracyGoals> goals;  ///< of the whole recording; no value for generated ones
};

/// The subject's name in a table: with the number of scans where they are a real log's first part.
[[nodiscard]] std::string with_scans(const Subject& subject, std::size_t scans);

/// Names of the real logs that this benchmark knows: "intel", "fr079", "mit-csail".
[[nodiscard]] const std::vector<std::string>& log_names();

/// The real logs beside the repository, the one called `log` alone when that is not empty. Where no log is
/// there and none was asked for, a generated building in `folder` stands in, and this says so. Errors: `log`
/// is not there; the folder cannot be written.
[[nodiscard]] Result<std::vector<Subject>> find_subjects(const std::string& log,
                                                         const std::filesystem::path& folder);

}  // namespace extperfc::benchmark
