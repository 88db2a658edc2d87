#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"

#include "ros/params/translator_params.hpp"

/// The translator's definitions and rules at the start.
namespace extperfc::ros_translate {

/// The set that the packages on ROS_PACKAGE_PATH become.
inline constexpr const char* kInstalledSet = "installed";

struct Knowledge {
  translate::DefinitionStore definitions;
  translate::RuleSet rules;
  std::string summary;                ///< "1200 definitions in indigo, installed, noetic; 43 rules"
  std::vector<std::string> problems;  ///< files that do not parse; the rest is known all the same
};

/// Reads everything that the parameters name. `package` is this package's folder; `package_paths` are the
/// folders of ROS_PACKAGE_PATH, those that count most first. Errors: a shipped store that is damaged, a
/// folder that is missing, and every rule that does not fit.
[[nodiscard]] Result<Knowledge> load_knowledge(const ros_params::TranslatorParams& params,
                                               const std::filesystem::path& package,
                                               const std::vector<std::filesystem::path>& package_paths);

/// The YAML files that the parameters name, in the order in which they are read.
[[nodiscard]] Result<std::vector<std::filesystem::path>> rule_files(const ros_params::TranslatorRules& params,
                                                                    const std::filesystem::path& package);

/// The folders of a search path such as ROS_PACKAGE_PATH.
[[nodiscard]] std::vector<std::filesystem::path> split_search_path(const std::string& search_path);

}  // namespace extperfc::ros_translate
