#pragma once

#include <filesystem>
#include <memory>

#include "extperfc/sources/scan_log.hpp"

/// Entry of the library extperfc_sources_scan_rawlog, which is loaded only when a rawlog is opened: MRPT
/// takes tens of megabytes of memory just by being there.
extern "C" void extperfc_open_scan_rawlog(
    const std::filesystem::path& file, const extperfc::sources::ScanLogOptions& options,
    extperfc::Result<std::unique_ptr<extperfc::sources::ScanLog>>& opened);
