#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simulate/worlds/material_reader.hpp"
#include "simulate/worlds/object_model.hpp"

namespace extperfc::simulate {

inline constexpr Span kAny{-1e4, 1e4};      ///< positions [m] and angles [deg]
inline constexpr Span kLength{1e-4, 1000};  ///< sizes [m]

/// Furniture, objects and plain shapes by the name of their kind; empty when there is no such kind.
/// config/worlds/README.md lists them with their keys.
[[nodiscard]] std::optional<ObjectModel> read_object_model(const std::string& kind, YamlMap& map,
                                                           const MaterialReader& materials);
[[nodiscard]] std::vector<std::string> object_kinds();

}  // namespace extperfc::simulate
