#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc {

/// Maps of a building's floors by name.
class Floors {
 public:
  /// Reads a YAML file; paths are relative to it:
  ///   floors:
  ///     - {name: ground, map: ground.yaml}
  ///     - {name: laboratory, map: /maps/laboratory.yaml}
  /// Errors name every problem with its line: names that are repeated, no floor, map files that are not
  /// there.
  [[nodiscard]] static Result<Floors> read(const std::filesystem::path& file);

  /// In the order of the file.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] bool has(const std::string& name) const;
  /// The map of a floor, read anew. Errors: kNotFound with the names that there are; those of load_map().
  [[nodiscard]] Result<OccupancyGrid> load(const std::string& name) const;

 private:
  struct Floor {
    std::string name;
    std::filesystem::path map;
  };
  [[nodiscard]] const Floor* find(const std::string& name) const;

  std::vector<Floor> floors_;
};

}  // namespace extperfc
