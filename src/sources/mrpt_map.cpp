#include "extperfc/sources/mrpt_map.hpp"

#include <string>
#include <system_error>

#include "extperfc/base/late_library.hpp"
#include "extperfc/base/text.hpp"

#include "sources/mrpt_map_entry.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

/// Address of an entry, or why `file` cannot be handled.
Result<void*> entry(const char* symbol, const fs::path& file) {
  static const char kHere = 0;
  auto found = late_symbol("extperfc_sources_mrpt_map", symbol, &kHere);
  if (found) return found;
  return fail(ErrorCode::kUnsupported, "maps of MRPT need MRPT (" + file.string() +
                                           "): " + found.error().message +
                                           "; install libmrpt-maps-dev and build again");
}

}  // namespace

bool names_gridmap(const fs::path& file) {
  return ends_with(file.string(), ".gridmap") || ends_with(file.string(), ".gridmap.gz");
}

Result<void> save_gridmap(const OccupancyGrid& map, const fs::path& file) {
  const auto found = entry("extperfc_save_gridmap", file);
  if (!found) return tl::unexpected(found.error());
  Result<void> saved;
  reinterpret_cast<decltype(&extperfc_save_gridmap)> (*found)(map, file, saved);
  return saved;
}

Result<OccupancyGrid> load_gridmap(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    return fail(ErrorCode::kNotFound, "cannot read the map " + file.string());
  const auto found = entry("extperfc_load_gridmap", file);
  if (!found) return tl::unexpected(found.error());
  Result<OccupancyGrid> map = fail(ErrorCode::kFailed, "");
  reinterpret_cast<decltype(&extperfc_load_gridmap)> (*found)(file, map);
  return map;
}

Result<void> save_simplemap(const std::vector<PlacedScan>& scans, const fs::path& file) {
  const auto found = entry("extperfc_save_simplemap", file);
  if (!found) return tl::unexpected(found.error());
  Result<void> saved;
  reinterpret_cast<decltype(&extperfc_save_simplemap)> (*found)(scans, file, saved);
  return saved;
}

}  // namespace extperfc::sources
