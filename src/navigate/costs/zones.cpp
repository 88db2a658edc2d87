#include <utility>

#include "extperfc/base/problems.hpp"
#include "extperfc/navigate/zone_layer.hpp"
#include "extperfc/world/map_file.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "navigate/costs/polygon.hpp"
#include "navigate/costs/zone_limits.hpp"

namespace extperfc::navigate {

namespace {

namespace fs = std::filesystem;

void read_polygon(YamlMap& item, Zone& zone) {
  const std::size_t problems = item.problems().size();
  Polygon corners_m;
  for (const auto& row : item.rows("polygon", 2, kFinite, 3)) corners_m.emplace_back(row[0], row[1]);
  const bool readable = item.problems().size() == problems;
  auto polygon = make_polygon(std::move(corners_m), kMaxZoneCorners);
  if (polygon)
    zone.corners_m = std::move(*polygon);
  else if (readable)
    item.problem("polygon", polygon.error().message);
}

void read_keep_out(YamlMap& item, const fs::path& folder, Zones& zones) {
  Zone zone;
  zone.name = item.text("name");
  if (const auto file = item.find_text("map")) {
    item.refuse("polygon", "a zone has a polygon or a map, not both: remove one");
    const fs::path path = fs::path(*file).is_relative() ? folder / *file : fs::path(*file);
    if (auto map = load_map(path))
      zones.keep_out_maps.push_back(std::move(*map));
    else
      item.problem("map", map.error().message, map.error().code);
  } else {
    read_polygon(item, zone);
    zones.keep_out.push_back(std::move(zone));
  }
  item.refuse_unknown();
}

void read_speed(YamlMap& item, Zones& zones) {
  constexpr Span kFactor{0.01, 1};
  SpeedZone zone;
  zone.name = item.text("name");
  zone.factor = item.number("factor", kFactor);
  read_polygon(item, zone);
  zones.speed.push_back(std::move(zone));
  item.refuse_unknown();
}

}  // namespace

Result<Zones> load_zones(const fs::path& file) {
  Problems problems(file.string(), ErrorCode::kCorrupt);
  const auto root = load_yaml(file, problems);
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap keys(*root, "", problems);
  Zones zones;
  for (YamlMap& item : keys.maps("keep_out")) read_keep_out(item, file.parent_path(), zones);
  for (YamlMap& item : keys.maps("speed")) read_speed(item, zones);
  keys.refuse_unknown();
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return zones;
}

}  // namespace extperfc::navigate
