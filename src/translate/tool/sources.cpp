#include "translate/tool/sources.hpp"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <system_error>

#include "extperfc/base/text.hpp"

namespace extperfc::translate {

namespace fs = std::filesystem;

Result<fs::path> config_folder(const Arguments& arguments) {
  const char* environment = std::getenv("EXTPERFC_TRANSLATE_CONFIG");  // NOLINT(concurrency-mt-unsafe)
  const auto given = arguments.last("--config");
  const fs::path folder = given ? *given : environment != nullptr ? environment : "";
  std::error_code error;
  if (folder.empty())
    return fail(ErrorCode::kInvalidArgument,
                "no definitions: give --config DIR (config/translate of the package), or run "
                "tools/extperfc-translate, which sets it");
  if (!fs::is_directory(folder / "definitions", error))
    return fail(ErrorCode::kNotFound, folder.string() + ": no folder 'definitions' there (--config)");
  return folder;
}

Result<DefinitionStore> open_store(const Arguments& arguments) {
  const auto folder = config_folder(arguments);
  if (!folder) return tl::unexpected(folder.error());
  DefinitionStore store;
  if (auto read = store.add_store(*folder / "definitions"); !read) return tl::unexpected(read.error());
  return store;
}

Result<void> read_tree(DefinitionStore& store, const std::string& folders, const std::string& set,
                       const std::string& fallback) {
  std::vector<std::string> paths;
  for (std::size_t begin = 0; begin <= folders.size();) {
    const auto end = std::min(folders.find(':', begin), folders.size());
    if (end > begin) paths.push_back(folders.substr(begin, end - begin));
    begin = end + 1;
  }
  // As in ROS_PACKAGE_PATH, the first folder's definitions count: they are read last.
  for (auto path = paths.rbegin(); path != paths.rend(); ++path) {
    const auto report = store.add_tree(*path, set, fallback);
    if (!report) return tl::unexpected(report.error());
    for (const auto& problem : report->problems)
      std::cerr << "extperfc-translate: left out: " << problem << "\n";
    if (report->read == 0 && report->problems.empty())
      return fail(ErrorCode::kNotFound, *path + ": no packages with msg/, srv/ or action/ there");
  }
  return {};
}

Result<void> check_set(const DefinitionStore& store, const std::string& set) {
  const auto sets = store.sets();
  if (std::find(sets.begin(), sets.end(), set) != sets.end()) return {};
  return fail(ErrorCode::kNotFound, "no set '" + set + "'; there are: " + joined(sets));
}

Result<std::vector<fs::path>> rule_files(const Arguments& arguments) {
  std::vector<fs::path> files;
  for (const auto& file : arguments.all("--rules")) files.emplace_back(file);
  if (!files.empty()) return files;
  const auto folder = config_folder(arguments);
  if (!folder) return tl::unexpected(folder.error());
  std::error_code error;
  for (fs::directory_iterator at(*folder, error), end; !error && at != end; at.increment(error))
    if (at->path().extension() == ".yaml" && at->is_regular_file()) files.push_back(at->path());
  if (error) return fail(ErrorCode::kFailed, folder->string() + ": " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace extperfc::translate
