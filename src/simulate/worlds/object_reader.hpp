#pragma once

#include <map>
#include <string>
#include <vector>

#include "extperfc/simulate/world_spec.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "simulate/worlds/material_reader.hpp"
#include "simulate/worlds/object_model.hpp"
#include "simulate/worlds/walls.hpp"

namespace extperfc::simulate {

/// Where something stands in the file, for problems that are found after reading.
struct Origin {
  int line{0};
  std::string key_path;
};

/// A body with what later checks and `on:` need to know about it.
struct PlacedObject {
  BodySpec body;
  Pose world_T_object{Pose::Identity()};
  std::vector<Surface> surfaces;
  Origin origin;
  std::string on;      ///< name of what it stands on; empty: the floor or a given height
  bool bounded{true};  ///< must lie within the floor plan
};

/// Turns the `objects` of a world into bodies: config/worlds/README.md describes each kind.
class ObjectReader {
 public:
  /// The corners of the floor plan are the default size of floors and ceilings.
  ObjectReader(Problems& problems, const Eigen::Vector2d& min_m, const Eigen::Vector2d& max_m)
      : problems_(&problems), min_m_(min_m), max_m_(max_m) {}

  /// Reads `materials` and `objects`.
  void read(YamlMap& world);
  [[nodiscard]] const std::vector<PlacedObject>& objects() const { return objects_; }

 private:
  /// Where the objects of a group stand, and what their names begin with.
  struct Group {
    Pose world_T_group{Pose::Identity()};
    std::string prefix;
    int depth{0};  ///< of groups in groups
  };

  /// What an object stands on. Without a name: what `at` says.
  struct Support {
    std::string name;
    Pose world_T_support{Pose::Identity()};
    Surface surface;
  };

  void read_list(YamlMap& owner, const Group& group);
  void read_object(const std::string& kind, YamlMap& map, const Group& group);
  void read_group(YamlMap& map, const Group& group);
  void read_slab(YamlMap& map, const Group& group, bool ceiling);
  void read_wall(YamlMap& map, const Group& group);
  void read_opening(YamlMap& map, WallParams& wall);
  void read_opening_door(YamlMap& opening, const WallParams& wall, const Group& group);
  void read_door(YamlMap& map, const Pose& world_T_opening, DoorParams params, const Group& group);
  void read_placed(YamlMap& map, const Group& group, ObjectModel model, const std::string& kind);
  [[nodiscard]] Support support(YamlMap& map, const Group& group) const;
  /// Puts a pose on its support; a problem when it is not above it.
  void rest_on(YamlMap& map, const Support& support, Pose& world_T_object) const;
  void keep(const YamlMap& map, const ObjectModel& model, const std::string& name, const Pose& world_T_object,
            const std::string& on = "", bool bounded = true);
  /// `name`, or one from the kind and a running number, with the group's prefix.
  [[nodiscard]] std::string name_of(YamlMap& map, const Group& group, const std::string& kind);
  [[nodiscard]] const PlacedObject* find(const std::string& name) const;

  Problems* problems_;
  Eigen::Vector2d min_m_;
  Eigen::Vector2d max_m_;
  MaterialReader materials_;
  std::map<std::string, int> running_numbers_;
  std::vector<PlacedObject> objects_;
  std::map<std::string, std::size_t> index_by_name_;
};

/// A list of points [x, y] [m], at least `min_count`.
[[nodiscard]] std::vector<Eigen::Vector2d> points_of(YamlMap& map, const std::string& key,
                                                     std::size_t min_count);

}  // namespace extperfc::simulate
