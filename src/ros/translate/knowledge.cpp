#include "ros/translate/knowledge.hpp"

#include <algorithm>
#include <sstream>
#include <system_error>
#include <utility>

namespace extperfc::ros_translate {

namespace {

namespace fs = std::filesystem;
using translate::DefinitionStore;

/// What embeds a type that its folder lacks, in packages that are installed: they are Noetic's.
constexpr const char* kInstalledFallback = "noetic";

Result<void> add_folder(DefinitionStore& definitions, const ros_params::TranslatorDefinitions::Folder& folder,
                        std::vector<std::string>& problems) {
  auto report = definitions.add_tree(folder.folder, folder.set, folder.fallback);
  if (!report) return tl::unexpected(report.error());
  std::move(report->problems.begin(), report->problems.end(), std::back_inserter(problems));
  return {};
}

/// Overlays come last, so that their version of a type is the set's.
Result<void> add_installed(DefinitionStore& definitions, std::vector<fs::path> package_paths,
                           std::vector<std::string>& problems) {
  std::reverse(package_paths.begin(), package_paths.end());
  for (const auto& path : package_paths) {
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) continue;  // a search path may name folders that are not there yet
    if (auto added = add_folder(definitions, {path, kInstalledSet, kInstalledFallback}, problems); !added)
      return added;
  }
  return {};
}

std::string summary_of(const Knowledge& knowledge) {
  std::ostringstream text;
  text << "definitions:";
  for (const auto& set : knowledge.definitions.sets()) {
    const auto content = knowledge.definitions.content(set);
    text << " " << set << " (" << content.messages.size() << " messages, " << content.services.size()
         << " services)";
  }
  text << "; rules: " << knowledge.rules.size();
  return text.str();
}

Result<DefinitionStore> load_definitions(const ros_params::TranslatorDefinitions& params,
                                         const fs::path& package, const std::vector<fs::path>& package_paths,
                                         std::vector<std::string>& problems) {
  DefinitionStore definitions;
  if (params.shipped)
    if (auto added = definitions.add_store(package / "config" / "translate" / "definitions"); !added)
      return tl::unexpected(added.error());
  if (params.installed)
    if (auto added = add_installed(definitions, package_paths, problems); !added)
      return tl::unexpected(added.error());
  for (const auto& folder : params.folders)
    if (auto added = add_folder(definitions, folder, problems); !added) return tl::unexpected(added.error());
  return definitions;
}

}  // namespace

Result<std::vector<fs::path>> rule_files(const ros_params::TranslatorRules& params, const fs::path& package) {
  auto named = params.files;
  if (params.shipped) named.insert(named.begin(), package / "config" / "translate");
  std::vector<fs::path> files;
  for (const auto& path : named) {
    std::error_code error;
    if (!fs::exists(path, error))
      return fail(ErrorCode::kNotFound, "rules/files: there is no " + path.string());
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    const auto begin = static_cast<std::ptrdiff_t>(files.size());
    for (const auto& entry : fs::directory_iterator(path, error))
      if (entry.path().extension() == ".yaml") files.push_back(entry.path());
    std::sort(files.begin() + begin, files.end());
  }
  return files;
}

std::vector<fs::path> split_search_path(const std::string& search_path) {
  std::vector<fs::path> folders;
  std::istringstream stream(search_path);
  for (std::string folder; std::getline(stream, folder, ':');)
    if (!folder.empty()) folders.emplace_back(folder);
  return folders;
}

Result<Knowledge> load_knowledge(const ros_params::TranslatorParams& params, const fs::path& package,
                                 const std::vector<fs::path>& package_paths) {
  Knowledge knowledge;
  auto definitions = load_definitions(params.definitions, package, package_paths, knowledge.problems);
  if (!definitions) return tl::unexpected(definitions.error());
  const auto files = rule_files(params.rules, package);
  if (!files) return tl::unexpected(files.error());
  auto rules = translate::load_rules(*files, *definitions);
  if (!rules) return tl::unexpected(rules.error());
  knowledge.definitions = std::move(*definitions);
  knowledge.rules = std::move(*rules);
  knowledge.summary = summary_of(knowledge);
  return knowledge;
}

}  // namespace extperfc::ros_translate
