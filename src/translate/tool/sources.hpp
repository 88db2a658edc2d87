#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/translate/definition_store.hpp"

namespace extperfc::translate {

/// --config DIR: the folder with definitions/ and the rules *.yaml; the launcher gives the package's. Its
/// environment variable EXTPERFC_TRANSLATE_CONFIG stands in when the option is not given.
[[nodiscard]] Result<std::filesystem::path> config_folder(const Arguments& arguments);

/// The shipped store.
[[nodiscard]] Result<DefinitionStore> open_store(const Arguments& arguments);

/// Reads trees of packages as set `set`; what does not parse is said on standard error, and counts as
/// unknown.
[[nodiscard]] Result<void> read_tree(DefinitionStore& store, const std::string& folders,
                                     const std::string& set, const std::string& fallback);

/// Errors name the sets that are there.
[[nodiscard]] Result<void> check_set(const DefinitionStore& store, const std::string& set);

/// The files of --rules, else the rules *.yaml of the configuration, sorted.
[[nodiscard]] Result<std::vector<std::filesystem::path>> rule_files(const Arguments& arguments);

}  // namespace extperfc::translate
