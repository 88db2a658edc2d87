#pragma once

#include <cstddef>
#include <filesystem>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/schema.hpp"

#include "translate/schema/catalogue.hpp"

/// The store on disk: <package>/<Name>.<key>.{msg,srv,action}, each with leading lines `# embeds <type>
/// <key>` and the definition's text; sets/<name>.txt with lines `<type> <kind> <key>`. Keys are those of
/// Catalogue.
namespace extperfc::translate {

/// Adds what the folder holds; returns the number of files of definitions. `catalogue` is as before after an
/// error, which names the file.
[[nodiscard]] Result<std::size_t> read_store(const std::filesystem::path& folder, const SchemaLimits& limits,
                                             Catalogue& catalogue);
/// Writes all but what was learned and what derives from an action. Files that are there already are
/// replaced.
[[nodiscard]] Result<void> write_store_files(const std::filesystem::path& folder, const Catalogue& catalogue);

}  // namespace extperfc::translate
