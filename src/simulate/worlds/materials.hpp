#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/world/shape.hpp"

namespace extperfc::simulate {

/// Names of all textures, in the order of the enumeration.
[[nodiscard]] std::vector<std::string> texture_names();

/// sRGB of a named colour ("red"), empty when the name is unknown.
[[nodiscard]] std::optional<Eigen::Vector3f> colour_from_name(const std::string& name);
[[nodiscard]] std::vector<std::string> colour_names();

/// Materials that every world knows: oak, pine, walnut, white, black, metal, plaster, tiles, parquet, ...
[[nodiscard]] const std::map<std::string, Material>& known_materials();

/// `material` with its colour multiplied by `factor` and kept in [0, 1].
[[nodiscard]] Material shaded(Material material, float factor);

}  // namespace extperfc::simulate
