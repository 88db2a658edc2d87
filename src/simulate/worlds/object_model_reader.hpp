#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simulate/worlds/material_reader.hpp"
#include "simulate/worlds/object_model.hpp"
#include "simulate/worlds/yaml_map.hpp"

namespace extperfc::simulate::worlds {

/// Furniture, objects and plain shapes by the name of their kind; empty when there is no such kind.
/// config/worlds/README.md lists them with their keys.
[[nodiscard]] std::optional<ObjectModel> read_object_model(const std::string& kind, YamlMap& map,
                                                           const MaterialReader& materials);
[[nodiscard]] std::vector<std::string> object_kinds();

}  // namespace extperfc::simulate::worlds
