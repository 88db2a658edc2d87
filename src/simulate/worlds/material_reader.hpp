#pragma once

#include <map>
#include <string>

#include "extperfc/world/shape.hpp"
#include "extperfc/world/yaml_map.hpp"

namespace extperfc::simulate {

/// Reads what surfaces look like; knows the built-in materials and those of the world itself.
class MaterialReader {
 public:
  MaterialReader();

  /// The map `materials` of a world: name -> {like, colour, texture, texture_size, gloss}.
  void read_own(YamlMap& world);

  /// `material` (a name) or `fallback`, changed by `colour`, `texture`, `texture_size` and `gloss` of the
  /// map.
  [[nodiscard]] Material read(YamlMap& map, const std::string& fallback) const;
  /// A further material of an object under its own key, by name only.
  [[nodiscard]] Material read_named(YamlMap& map, const std::string& key, const std::string& fallback) const;

 private:
  std::map<std::string, Material> materials_;
};

/// "red", "#c02020" or [0.8, 0.1, 0.1].
[[nodiscard]] Eigen::Vector3f read_colour(YamlMap& map, const std::string& key,
                                          const Eigen::Vector3f& fallback);

}  // namespace extperfc::simulate
