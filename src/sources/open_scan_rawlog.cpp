#include <system_error>

#include "extperfc/base/late_library.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "sources/scan_rawlog.hpp"

namespace extperfc::sources {

Result<std::unique_ptr<ScanLog>> open_scan_rawlog(const std::filesystem::path& file,
                                                  const ScanLogOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    return fail(ErrorCode::kNotFound, "no such file: " + file.string());
  static const char kHere = 0;
  const auto entry = late_symbol("extperfc_sources_scan_rawlog", "extperfc_open_scan_rawlog", &kHere);
  if (!entry)
    return fail(ErrorCode::kUnsupported, "cannot read the rawlog " + file.string() + ": " +
                                             entry.error().message +
                                             "; install MRPT (libmrpt-obs-dev) and build again");
  Result<std::unique_ptr<ScanLog>> opened = fail(ErrorCode::kFailed, "");
  reinterpret_cast<decltype(&extperfc_open_scan_rawlog)> (*entry)(file, options, opened);
  return opened;
}

}  // namespace extperfc::sources
