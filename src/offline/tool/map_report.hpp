#pragma once

#include <optional>
#include <string>
#include <vector>

#include "extperfc/mapping/mapper.hpp"
#include "extperfc/offline/map_recording.hpp"
#include "extperfc/offline/relations.hpp"

#include "offline/tool/map_options.hpp"

namespace extperfc::offline {

/// The contents of a report.
struct MapReport {
  const MapOptions& options;
  MappingResult result;
  mapping::MapperStatistics statistics;
  std::size_t map_width{0};   ///< cells
  std::size_t map_height{0};  ///< cells
  double peak_memory_mb{0};
  std::vector<Relation> relations;
  std::optional<RelationsScore> score;
};

[[nodiscard]] std::string report_text(const MapReport& report);
[[nodiscard]] std::string report_json(const MapReport& report);

}  // namespace extperfc::offline
