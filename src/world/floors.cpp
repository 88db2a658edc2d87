#include "extperfc/world/floors.hpp"

#include <algorithm>
#include <utility>

#include "extperfc/base/problems.hpp"
#include "extperfc/base/text.hpp"
#include "extperfc/world/map_file.hpp"
#include "extperfc/world/yaml_map.hpp"

namespace extperfc {

namespace fs = std::filesystem;

Result<Floors> Floors::read(const fs::path& file) {
  Problems problems(file.string(), ErrorCode::kCorrupt);
  const auto root = load_yaml(file, problems);
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap keys(*root, "", problems);
  Floors floors;
  for (YamlMap& item : keys.maps("floors", 1)) {
    Floor floor{item.text("name"), item.text("map")};
    if (floor.map.is_relative()) floor.map = file.parent_path() / floor.map;
    if (floors.has(floor.name)) item.problem("name", "is the name of two floors: rename one");
    if (item.has("map") && !fs::is_regular_file(floor.map))
      item.problem("map", "no such file: " + floor.map.string(), ErrorCode::kNotFound);
    item.refuse_unknown();
    floors.floors_.push_back(std::move(floor));
  }
  keys.refuse_unknown();
  if (!problems.empty()) return tl::unexpected(problems.to_error());
  return floors;
}

std::vector<std::string> Floors::names() const {
  std::vector<std::string> names;
  names.reserve(floors_.size());
  for (const Floor& floor : floors_) names.push_back(floor.name);
  return names;
}

const Floors::Floor* Floors::find(const std::string& name) const {
  const auto found = std::find_if(floors_.begin(), floors_.end(),
                                  [&name](const Floor& floor) { return floor.name == name; });
  return found == floors_.end() ? nullptr : &*found;
}

bool Floors::has(const std::string& name) const {
  return find(name) != nullptr;
}

Result<OccupancyGrid> Floors::load(const std::string& name) const {
  const Floor* floor = find(name);
  if (floor == nullptr)
    return fail(ErrorCode::kNotFound, "there is no floor " + in_quotes(name) + hint_or_names(name, names()));
  return load_map(floor->map);
}

}  // namespace extperfc
