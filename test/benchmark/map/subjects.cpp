#include "test/benchmark/map/subjects.hpp"

#include <iostream>

#include "test/benchmark/map/options.hpp"

namespace extperfc::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr double kStandInS = 300;  // of driving: once around and into some rooms

struct KnownLog {
  const char* file;  // without its endings
  const char* name;
  AccuracyGoals goals;
};

constexpr KnownLog kLogs[] = {
    {"intel", "Intel", {0.007, 0.15}},
    {"fr079", "fr079", {0.012, 0.26}},
    {"mit-csail", "mit-csail", {0.012, 0.26}},
};

// The dots are for the system to follow: the folder may be a link.
fs::path data_folder() {
  return fs::path(EXTPERFC_SOURCE_DIR) / "../shared/data/slam";
}

Result<std::vector<Subject>> stand_in(const fs::path& folder) {
  std::cout << data_folder().string() << " holds no logs: a generated building stands in for them, and their "
            << "goals are left out\n";
  auto office = record_office({360, 10, kStandInS}, folder);
  if (!office) return tl::unexpected(office.error());
  return std::vector<Subject>{{"office", *std::move(office), std::nullopt}};
}

}  // namespace

std::string with_scans(const Subject& subject, std::size_t scans) {
  return scans == kWholeLog || !subject.goals ? subject.name
                                              : subject.name + ", first " + std::to_string(scans) + " scans";
}

const std::vector<std::string>& log_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> files;
    for (const auto& log : kLogs) files.emplace_back(log.file);
    return files;
  }();
  return names;
}

Result<std::vector<Subject>> find_subjects(const std::string& log, const fs::path& folder) {
  std::vector<Subject> found;
  for (const auto& known : kLogs) {
    if (!log.empty() && log != known.file) continue;
    const auto file = data_folder() / known.file;
    const Recording recording{file.string() + ".clf.bz2", file.string() + ".relations"};
    if (fs::exists(recording.log) && fs::exists(recording.relations))
      found.push_back({known.name, recording, known.goals});
  }
  if (!found.empty()) return found;
  if (log.empty()) return stand_in(folder);
  return fail(ErrorCode::kNotFound, "no log '" + log + "' in " + data_folder().string() + ": it needs " +
                                        log + ".clf.bz2 and " + log + ".relations");
}

}  // namespace extperfc::benchmark
