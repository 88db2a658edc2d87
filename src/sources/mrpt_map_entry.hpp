#pragma once

#include <filesystem>
#include <vector>

#include "extperfc/sources/mrpt_map.hpp"

/// Entries of the library extperfc_sources_mrpt_map, which is loaded only when one is called: MRPT takes tens
/// of megabytes of memory just by being there. See mrpt_map.hpp.
extern "C" void extperfc_save_gridmap(const extperfc::OccupancyGrid& map, const std::filesystem::path& file,
                                      extperfc::Result<void>& saved);
extern "C" void extperfc_load_gridmap(const std::filesystem::path& file,
                                      extperfc::Result<extperfc::OccupancyGrid>& map);
extern "C" void extperfc_save_simplemap(const std::vector<extperfc::sources::PlacedScan>& scans,
                                        const std::filesystem::path& file, extperfc::Result<void>& saved);
